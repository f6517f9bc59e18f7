// Shapes: outsides of bodies and how modes move them, out of their compressed numbers.

const DEFLECTION = 0.05; // largest deflection drawn, relative to the diagonal

async function loadShapes() {
  const place = document.getElementById("shapes");
  if (!place) return null;
  const shapes = await (await unpacked("shapes")).json();
  return { ...shapes, steps: Number(place.dataset.steps) };
}

function bodiesOf(shapes, key) {
  const scene = shapes.scenes[key];
  if (!scene.ready) {
    let first = 0;
    scene.ready = scene.bodies.map((body) => {
      const rest = body.points.map((places, axis) =>
        Float32Array.from(places, (place) => scene.low[axis] + scene.step * place));
      const made = {
        name: body.name, rest, first,
        triangles: body.triangles,
        edges: body.edges,
        sharp: body.sharp,
      };
      first += rest[0].length;
      return made;
    });
  }
  return scene.ready;
}

function diagonal(scene) {
  return Math.hypot(...scene.high.map((high, axis) => high - scene.low[axis]));
}

// Positions and deflections (relative to the largest) of the points of every body at a phase.
function deformed(shapes, mode, phase, size) {
  const scene = shapes.scenes[mode.scene];
  const scale = DEFLECTION * size * diagonal(scene);
  const c = Math.cos(phase) / shapes.steps;
  const s = Math.sin(phase) / shapes.steps;
  return bodiesOf(shapes, mode.scene).map((body) => {
    const count = body.rest[0].length;
    const deflection = new Float32Array(count);
    const places = body.rest.map((rest, axis) => {
      const moved = new Float32Array(count);
      for (let i = 0; i < count; i += 1) {
        const u = c * mode.real[axis][body.first + i] - s * mode.imaginary[axis][body.first + i];
        moved[i] = rest[i] + scale * u;
        deflection[i] += u * u;
      }
      return moved;
    });
    return { places, deflection: deflection.map(Math.sqrt) };
  });
}

// Ends of line segments with gaps between them.
function segments(pairs, places) {
  return places.map((place) => {
    const line = new Float32Array(3 * pairs[0].length);
    for (let i = 0; i < pairs[0].length; i += 1) {
      line[3 * i] = place[pairs[0][i]];
      line[3 * i + 1] = place[pairs[1][i]];
      line[3 * i + 2] = NaN;
    }
    return line;
  });
}
