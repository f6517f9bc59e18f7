// Modes that vibrate in space.

const SIGNS = { unstable: "▲", "grows slowly": "△", undecided: "◆", stable: "●", rigid: "○" };
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
