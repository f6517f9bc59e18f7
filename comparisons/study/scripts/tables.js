// Tables: a button in each heading sorts the rows by its column.

const RISING = "ascending";
const FALLING = "descending";

function valueOf(row, column) {
  const cell = row.cells[column];
  const number = cell.dataset.value;
  return number === undefined ? cell.textContent.trim() : number === "" ? null : Number(number);
}

// Missing values stay last, whichever way the others go.
function compared(a, b, way) {
  if (a === null || b === null) return (a === null) - (b === null);
  const order = typeof a === "number" && typeof b === "number"
    ? a - b
    : String(a).localeCompare(String(b), "en", { numeric: true });
  return way === RISING ? order : -order;
}

function sortTable(table, heading) {
  const way = heading.getAttribute("aria-sort") === RISING ? FALLING : RISING;
  for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
  heading.setAttribute("aria-sort", way);
  const rows = [...table.tBodies[0].rows];
  const values = new Map(rows.map((row) => [row, valueOf(row, heading.cellIndex)]));
  rows.sort((a, b) => compared(values.get(a), values.get(b), way));
  table.tBodies[0].append(...rows);
}

function makeSortable(table) {
  for (const heading of table.tHead.rows[0].cells) {
    const button = document.createElement("button");
    button.type = "button";
    button.title = "sort by this column";
    button.append(...heading.childNodes);
    heading.append(button);
    button.addEventListener("click", () => sortTable(table, heading));
  }
}

// Where a row stands for a mode, the number of the mode becomes a button that shows it.
function linkRows(table, show) {
  for (const row of table.querySelectorAll("tr[data-mode]")) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "show";
    button.title = "show the shape of this mode";
    const cell = row.querySelector("[data-show]");
    button.append(...cell.childNodes);
    button.addEventListener("click", () => show(row.dataset.mode, true));
    cell.append(button);
  }
}

function markRow(table, mode) {
  for (const row of table.querySelectorAll("tr[data-mode]")) {
    row.classList.toggle("shown", row.dataset.mode === mode);
  }
}
