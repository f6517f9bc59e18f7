// What happens when a page opens.

async function start() {
  const nav = document.querySelector("nav");
  if (nav) followSections(nav);
  const tables = [...document.querySelectorAll("table")].filter((table) => table.tHead);
  tables.forEach(makeSortable);
  if (document.getElementById("library")) await drawAll(tables);
  document.documentElement.dataset.ready = "";
}

async function drawAll(tables) {
  const plots = [...document.querySelectorAll(".plot")];
  await loadLibrary();
  const shapes = await loadShapes();
  const place = document.querySelector(".viewer");
  const ring = (mode) => {
    plots.forEach((plot) => ringMode(plot, mode));
    tables.forEach((table) => markRow(table, mode));
  };
  const viewer = place && shapes ? new ModeViewer(place, shapes, ring) : null;
  const show = (mode, inSight) => viewer?.show(mode, inSight);
  if (viewer) tables.forEach((table) => linkRows(table, show));
  for (const plot of plots) await drawPlot(plot, show);
  if (viewer?.select.options.length) await viewer.show(place.dataset.first);
}

start().catch((error) => {
  document.documentElement.dataset.failed = String(error);
  throw error;
});
