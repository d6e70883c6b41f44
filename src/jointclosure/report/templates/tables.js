"use strict";
// Tables sort by a click on a heading; those that are marked get a field that filters their rows.

function sortKey(row, column) {
  const cell = row.cells[column];
  return cell.hasAttribute("data-number") ? Number(cell.dataset.key) : cell.dataset.key;
}

// numbers before words, by size; what is absent last, whichever way the table is sorted
function compareKeys(one, other, direction) {
  if (one === "" || other === "") return (one === "") - (other === "");
  if (typeof one !== typeof other) return typeof one === "number" ? -1 : 1;
  const order = typeof one === "number" ? one - other : one.localeCompare(other, "en", { numeric: true });
  return direction * order;
}

function sortTable(table, column) {
  const headings = [...table.tHead.rows[0].cells];
  const ascending = headings[column].getAttribute("aria-sort") !== "ascending";
  headings.forEach((heading) => heading.removeAttribute("aria-sort"));
  headings[column].setAttribute("aria-sort", ascending ? "ascending" : "descending");
  const rows = [...table.tBodies[0].rows].map((row) => [sortKey(row, column), row]);
  rows.sort((one, other) => compareKeys(one[0], other[0], ascending ? 1 : -1));
  table.tBodies[0].append(...rows.map((pair) => pair[1]));
}

function addSorting(table) {
  [...table.tHead.rows[0].cells].forEach((heading, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = heading.textContent;
    button.addEventListener("click", () => sortTable(table, column));
    heading.replaceChildren(button);
  });
}

// a row stays where each word stands somewhere in it
function addFilter(sheet) {
  const rows = [...sheet.querySelectorAll("tbody tr")];
  const box = document.createElement("div");
  const label = document.createElement("label");
  const field = document.createElement("input");
  const count = document.createElement("output");
  field.type = "search";
  box.className = "filter";
  label.append("Show rows with ", field);
  box.append(label, count);
  const apply = () => {
    const words = field.value.toLowerCase().split(/\s+/);
    const hits = rows.filter((row) => {
      const text = [...row.cells].map((cell) => cell.textContent).join(" ");
      row.hidden = !words.every((word) => text.toLowerCase().includes(word));
      return !row.hidden;
    });
    count.textContent = `${hits.length} of ${rows.length} rows`;
  };
  field.addEventListener("input", apply);
  apply();
  sheet.querySelector(".scroll").before(box);
}

document.querySelectorAll(".sheet table").forEach((table) => {
  if (table.tHead.rows.length && table.tBodies[0].rows.length > 1) addSorting(table);
});
document.querySelectorAll(".sheet[data-filtered]").forEach(addFilter);
