"use strict";
(() => {
  const table = document.querySelector("table");
  if (!table) return;
  const body = table.tBodies[0];
  const rows = Array.from(body.rows);
  const heads = Array.from(table.tHead.rows[0].cells);
  const select = document.querySelector("select");
  const search = document.querySelector("input");
  const texts = new Intl.Collator("en", { numeric: true });
  let column = -1;
  let down = false;

  const value = (row) => {
    const cell = row.cells[column];
    return cell.dataset.value === undefined ? cell.textContent : Number(cell.dataset.value);
  };
  const sort = (by) => {
    const number = heads[by].classList.contains("number");
    down = column === by ? !down : number;
    column = by;
    const keyed = rows.map((row, index) => [value(row), index, row]);
    const compare = number ? (a, b) => a - b : texts.compare;
    keyed.sort((a, b) => (down ? compare(b[0], a[0]) : compare(a[0], b[0])) || a[1] - b[1]);
    body.append(...keyed.map((entry) => entry[2]));
    heads.forEach((head, index) => {
      if (head.hasAttribute("aria-sort"))
        head.setAttribute("aria-sort", index !== by ? "none" : down ? "descending" : "ascending");
    });
  };

  select.append(new Option("as given", "", true));
  heads.forEach((head, index) => {
    const button = head.querySelector("button");
    if (!button) return;
    button.addEventListener("click", () => sort(index));
    select.append(new Option(button.textContent, String(index)));
  });
  select.addEventListener("change", () => {
    if (select.value) { column = -1; sort(Number(select.value)); } else body.append(...rows);
  });
  search.addEventListener("input", () => {
    const wanted = search.value.toLowerCase();
    for (const row of rows) row.hidden = !row.cells[1].textContent.toLowerCase().includes(wanted);
  });
  document.querySelector(".tools").hidden = false;
})();
