// Plots: plotly.js out of its compressed text, and the look that all plots share.

const NARROW = 600; // pixels: a phone
const LOW = 360; // pixels: no plot fills a phone alone
const TINY = 240; // pixels: half a phone

function bytesOf(text) {
  const characters = atob(text.trim());
  return Uint8Array.from(characters, (character) => character.charCodeAt(0));
}

function unpacked(id) {
  const packed = new Blob([bytesOf(document.getElementById(id).textContent)]);
  return new Response(packed.stream().pipeThrough(new DecompressionStream("gzip")));
}

async function loadLibrary() {
  const script = document.createElement("script");
  script.textContent = await (await unpacked("library")).text();
  document.head.append(script);
}

const FONT = { family: "system-ui, -apple-system, Segoe UI, Roboto, sans-serif", color: "#1f2328" };
const MODEBAR = { bgcolor: "rgba(255,255,255,0.8)", color: "#8a8a8a", activecolor: "#1f2328" };
const AXIS = {
  gridcolor: "#e4e4e4", zerolinecolor: "#8a8a8a", linecolor: "#555", ticks: "outside",
  ticklen: 4, tickcolor: "#999", automargin: true,
};

function isNarrow() {
  return innerWidth < NARROW;
}

// Buttons that the library may add of itself, to send data elsewhere, stay out.
const BUTTONS = [["zoom2d", "pan2d", "resetScale2d", "toImage"]];
const BUTTONS_IN_SPACE = [["tableRotation", "pan3d", "zoom3d", "resetCameraDefault3d", "toImage"]];

function settings(buttons) {
  return {
    responsive: true,
    displaylogo: false,
    displayModeBar: isNarrow() ? false : "hover",
    modeBarButtons: buttons,
    scrollZoom: false,
  };
}

function styled(figure, place) {
  const narrow = isNarrow();
  const small = place.clientWidth < TINY ? { title: { text: "" } } : {};
  const { xaxis, yaxis, ...layout } = figure.layout;
  return {
    font: { ...FONT, size: narrow ? 11 : 12.5 },
    margin: { l: 56, r: 12, t: 8, b: 44 },
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
    hovermode: "closest",
    modebar: MODEBAR,
    hoverlabel: { font: { ...FONT, size: 12 }, align: "left", bgcolor: "#fff" },
    dragmode: narrow ? false : "zoom",
    legend: {
      orientation: "h", x: 0, y: 1.02, yanchor: "bottom", itemsizing: "constant",
      traceorder: "normal",
    },
    ...layout,
    height: narrow ? Math.min(layout.height, LOW) + (layout.meta?.narrow ?? 0) : layout.height,
    xaxis: { ...AXIS, ...xaxis, ...small },
    yaxis: { ...AXIS, ...yaxis, ...small },
  };
}

// Draws one plot; a click on a point that stands for a mode shows that mode.
async function drawPlot(place, show) {
  const figure = JSON.parse(document.getElementById(place.dataset.figure).textContent);
  place.textContent = "";
  await Plotly.newPlot(place, figure.data, styled(figure, place), settings(BUTTONS));
  place.on("plotly_click", (event) => {
    const mode = event.points[0].customdata;
    if (typeof mode === "string") show(mode, false);
  });
}

// Rings the point of the mode that is shown, in every plot that has it.
function ringMode(place, mode) {
  const ring = place.data?.findIndex((trace) => trace.meta === "shown");
  if (ring === undefined || ring < 0) return;
  for (const trace of place.data) {
    const point = trace.customdata?.indexOf(mode) ?? -1;
    if (point < 0 || trace.meta === "shown") continue;
    Plotly.restyle(place, { x: [[trace.x[point]]], y: [[trace.y[point]]] }, [ring]);
    return;
  }
  Plotly.restyle(place, { x: [[]], y: [[]] }, [ring]);
}
