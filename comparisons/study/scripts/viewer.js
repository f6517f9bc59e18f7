// Views in space: bodies with their meshes, and modes that vibrate.

const SIGNS = { unstable: "▲", "grows slowly": "△", undecided: "◆", stable: "●", rigid: "○" };
const BODY_COLOURS = ["#8fbcd9", "#e6b06c", "#93c9a8", "#d4a5c3", "#c9c36b", "#b0b7bf"];
const PERIOD = 2.4; // seconds of a period on the screen
const LIGHT = {
  ambient: 0.72, diffuse: 0.4, specular: 0.05, roughness: 0.9, fresnel: 0.05,
  facenormalsepsilon: 1e-20, vertexnormalsepsilon: 1e-20, // bodies are small in metres
};

function spaceLayout(scene, height) {
  const margin = DEFLECTION * diagonal(scene);
  const extents = scene.high.map((high, axis) => high - scene.low[axis] + 2 * margin);
  const largest = Math.max(...extents);
  const axis = (i) => ({
    visible: false, showspikes: false,
    range: [scene.low[i] - margin, scene.high[i] + margin],
  });
  const [x, y, z] = extents.map((extent) => ((scene.flat ? 1.5 : 1.9) * extent) / largest);
  return {
    font: { ...FONT, size: isNarrow() ? 11 : 12.5 },
    height, margin: { l: 0, r: 0, t: 0, b: 0 },
    paper_bgcolor: "rgba(0,0,0,0)",
    hoverlabel: { font: { ...FONT, size: 12 }, bgcolor: "#fff" },
    modebar: MODEBAR,
    legend: { orientation: "h", x: 0, y: 1, yanchor: "top", itemsizing: "constant" },
    scene: {
      xaxis: axis(0), yaxis: axis(1), zaxis: axis(2),
      aspectmode: "manual", aspectratio: { x, y, z },
      dragmode: scene.flat ? "pan" : "turntable",
      camera: {
        projection: { type: "orthographic" },
        center: { x: 0, y: scene.flat ? -0.08 : 0, z: scene.flat ? 0 : -0.05 },
        eye: Object.fromEntries(["x", "y", "z"].map((name, i) => [name, 1.6 * scene.view[i]])),
        up: scene.flat ? { x: 0, y: 1, z: 0 } : { x: 0, y: 0, z: 1 },
      },
    },
  };
}

function lineTrace(line, colour, width, more) {
  return {
    type: "scatter3d", mode: "lines", hoverinfo: "skip", showlegend: false,
    x: line[0], y: line[1], z: line[2], line: { color: colour, width }, ...more,
  };
}

// Light from where one looks; flat bodies need none.
function lit(scene) {
  if (scene.flat) return { lighting: { ...LIGHT, ambient: 1, diffuse: 0, specular: 0 } };
  const [x, y, z] = scene.view.map((part, i) => 1e5 * (part + (i === 2 ? 1 : 0)));
  return { lighting: LIGHT, lightposition: { x, y, z } };
}

// Traces of a body that moves: its outside, and lines as functions of its points.
function movingTraces(body, moved, first, mesh, light) {
  const [i, j, k] = body.triangles;
  const [x, y, z] = moved.places;
  return [
    {
      type: "mesh3d", name: body.name, x, y, z, i, j, k,
      intensity: moved.deflection, cmin: 0, cmax: 1, colorscale: "YlGnBu", reversescale: true,
      flatshading: true, ...light, showscale: first,
      hovertemplate: "%{intensity:.2f} of the largest displacement<extra>%{fullData.name}</extra>",
      colorbar: {
        title: { text: "displacement / largest", side: "top" }, orientation: "h",
        thickness: 10, len: 0.5, x: 0.5, y: 0, yanchor: "bottom", nticks: 3, outlinewidth: 0,
      },
    },
    lineTrace(segments(body.sharp, body.rest), "#b9bfc6", 2),
    lineTrace(segments(body.sharp, moved.places), "#303840", 3),
    lineTrace(segments(body.edges, moved.places), "#5c646d", 1, { visible: mesh }),
  ];
}

class ModeViewer {
  constructor(place, shapes, told) {
    Object.assign(this, { place, shapes, told, phase: 0, playing: false, busy: false });
    const find = (name) => place.querySelector(name);
    this.scene = find(".scene");
    this.select = find(".mode");
    this.slider = find(".phase");
    this.size = find(".size");
    this.mesh = find(".mesh");
    this.playButton = find(".play");
    this.text = find(".told");
    this.fill();
    this.select.addEventListener("change", () => this.show(this.select.value));
    this.slider.addEventListener("input", () => {
      this.pause();
      this.setPhase((this.slider.value * Math.PI) / 180);
    });
    this.size.addEventListener("input", () => this.move());
    this.mesh.addEventListener("change", () => this.draw());
    this.playButton.addEventListener("click", () => (this.playing ? this.pause() : this.play()));
    find(".previous").addEventListener("click", () => this.step(-1));
    find(".next").addEventListener("click", () => this.step(1));
  }

  fill() {
    for (const [key, modes] of Object.entries(this.shapes.modes)) {
      let into = this.select;
      const title = Object.values(modes)[0]?.title;
      if (title) {
        into = document.createElement("optgroup");
        into.label = title;
        this.select.append(into);
      }
      for (const mode of Object.values(modes).sort((a, b) => a.number - b.number)) {
        into.append(new Option(this.words(mode), `${key}/${mode.number}`));
      }
    }
  }

  words(mode) {
    return `${SIGNS[mode.verdict]} mode ${mode.number}: ${mode.frequency} Hz, growth ${mode.growth} 1/s`;
  }

  modeOf(key) {
    const [result, number] = key.split("/");
    return this.shapes.modes[result]?.[number];
  }

  async show(key, inSight = false) {
    const mode = this.modeOf(key);
    if (!mode) {
      this.text.textContent = "The shape of this mode is not part of this page; those of the list are.";
      return;
    }
    const fresh = !this.mode || this.mode.scene !== mode.scene;
    this.mode = mode;
    this.select.value = key;
    this.place.dataset.shown = key;
    this.text.textContent = [mode.title, `${this.words(mode)}, ${mode.verdict}.`].filter(Boolean).join(", ");
    this.told(key);
    if (inSight) this.place.scrollIntoView({ behavior: "smooth", block: "nearest" });
    await (fresh ? this.draw() : this.move());
  }

  step(way) {
    const count = this.select.options.length;
    const next = (this.select.selectedIndex + way + count) % count;
    this.show(this.select.options[next].value);
  }

  async draw() {
    const moved = deformed(this.shapes, this.mode, this.phase, Number(this.size.value));
    const bodies = bodiesOf(this.shapes, this.mode.scene);
    const light = lit(this.shapes.scenes[this.mode.scene]);
    const traces = bodies.flatMap((body, i) =>
      movingTraces(body, moved[i], i === 0, this.mesh.checked, light));
    const camera = this.scene.layout?.scene?.camera;
    const scene = this.shapes.scenes[this.mode.scene];
    const layout = spaceLayout(scene, this.height());
    if (camera && this.drawn === this.mode.scene) layout.scene.camera = camera;
    this.drawn = this.mode.scene;
    await Plotly.react(this.scene, traces, layout, settings(BUTTONS_IN_SPACE));
  }

  height() {
    return isNarrow() ? 330 : 430;
  }

  // Moves what is drawn; calls that come while it is drawn are answered by one more move.
  async move() {
    if (this.busy) {
      this.again = true;
      return;
    }
    this.busy = true;
    const moved = deformed(this.shapes, this.mode, this.phase, Number(this.size.value));
    const update = { x: [], y: [], z: [], intensity: [] };
    const traces = [];
    bodiesOf(this.shapes, this.mode.scene).forEach((body, i) => {
      const { places, deflection } = moved[i];
      const add = (trace, [x, y, z], intensity) => {
        traces.push(4 * i + trace);
        update.x.push(x);
        update.y.push(y);
        update.z.push(z);
        update.intensity.push(intensity);
      };
      add(0, places, deflection);
      add(2, segments(body.sharp, places));
      if (this.mesh.checked) add(3, segments(body.edges, places));
    });
    await Plotly.restyle(this.scene, update, traces);
    this.busy = false;
    this.place.dataset.phase = Math.round((this.phase * 180) / Math.PI);
    if (this.again) {
      this.again = false;
      await this.move();
    }
  }

  async setPhase(phase) {
    this.phase = phase % (2 * Math.PI);
    const degrees = Math.round((this.phase * 180) / Math.PI);
    this.slider.value = degrees;
    this.place.querySelector("output").textContent = `${degrees}°`;
    await this.move();
  }

  play() {
    this.playing = true;
    this.playButton.setAttribute("aria-pressed", "true");
    this.playButton.textContent = "❚❚ pause";
    let last = performance.now();
    const frame = async (now) => {
      if (!this.playing) return;
      const turned = (2 * Math.PI * Math.min(now - last, 200)) / (1000 * PERIOD);
      last = now;
      await this.setPhase(this.phase + turned);
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  pause() {
    this.playing = false;
    this.playButton.setAttribute("aria-pressed", "false");
    this.playButton.textContent = "▶ play";
  }
}

// Bodies at rest, each in a colour, with the edges of their elements and the contact points.
async function drawGeometry(place, shapes) {
  const scene = shapes.scenes[place.dataset.scene];
  const contacts = scene.contacts ?? [];
  const above = new Set(contacts.map((contact) => contact.a)); // what hides contact points
  const traces = contacts.flatMap((contact) => contactTraces(shapes, scene, contact));
  // What is seen through comes last, or it would hide what lies behind.
  traces.push(...bodiesOf(shapes, place.dataset.scene).flatMap((body, index) => {
    const [i, j, k] = body.triangles;
    const [x, y, z] = body.rest;
    const colour = BODY_COLOURS[index % BODY_COLOURS.length];
    const group = { name: body.name, legendgroup: body.name };
    const opacity = above.has(body.name) && !scene.flat ? 0.6 : 1;
    return [
      {
        type: "mesh3d", x, y, z, i, j, k, color: colour, opacity, flatshading: true, ...lit(scene),
        showlegend: true, hovertemplate: "x %{x:.4g} m<br>y %{y:.4g} m<br>z %{z:.4g} m", ...group,
      },
      // Outsides that were reduced have no edges of elements left.
      lineTrace(segments(scene.reduced ? body.sharp : body.edges, body.rest), "#4d5660", 1, group),
    ];
  }));
  place.textContent = "";
  const layout = spaceLayout(scene, isNarrow() ? 330 : 460);
  await Plotly.newPlot(place, traces, layout, settings(BUTTONS_IN_SPACE));
}

function contactTraces(shapes, scene, contact) {
  const at = rows(numbers(shapes, contact.points), 3).map((places, axis) =>
    Float32Array.from(places, (value) => scene.low[axis] + scene.step * value));
  const group = { name: `contact ${contact.name}`, legendgroup: contact.name };
  const points = {
    type: "scatter3d", mode: "markers", x: at[0], y: at[1], z: at[2],
    marker: { size: 2.2, color: "#d55e00" }, ...group,
    hovertemplate: "contact point<br>x %{x:.4g} m<br>y %{y:.4g} m<br>z %{z:.4g} m",
  };
  if (!contact.arrows) return [points];
  const [from, along] = [contact.arrows.from, contact.arrows.along];
  const axis = (list, i) => list.map((vector) => vector[i]);
  return [points, {
    type: "cone", anchor: "tail", sizemode: "absolute", sizeref: 0.045 * diagonal(scene),
    x: axis(from, 0), y: axis(from, 1), z: axis(from, 2),
    u: axis(along, 0), v: axis(along, 1), w: axis(along, 2),
    colorscale: [[0, "#222222"], [1, "#222222"]], showscale: false, showlegend: true,
    name: "friction on side a", hoverinfo: "name",
  }];
}
