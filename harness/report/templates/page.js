"use strict";
// What a page of a report does beside being read: commands of rows, arrow keys, paper.
(() => {
  const buttonsOf = (table) => [...table.querySelectorAll("td.again > button")];

  // A table is one stop of the tabulator. `next` says which item a key leads to from another.
  const rove = (items, next) => {
    const select = (chosen) => {
      for (const item of items) item.tabIndex = item === chosen ? 0 : -1;
    };
    for (const item of items) {
      item.addEventListener("focus", () => select(item));
      item.addEventListener("keydown", (event) => {
        if (event.ctrlKey || event.metaKey || event.altKey) return;
        const chosen = next(item, event.key);
        if (!chosen) return;
        event.preventDefault();
        chosen.focus();
      });
    }
    if (items.length) select(items[0]);
  };

  const alongLine = (items) => (item, key) => {
    const last = items.length - 1;
    const at = items.indexOf(item);
    return { ArrowUp: items[at - 1], ArrowDown: items[at + 1], Home: items[0], End: items[last] }[key];
  };

  // Cells without a link are passed over.
  const alongGrid = (table) => (item, key) => {
    const cell = item.closest("td");
    const step = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] }[key];
    if (!step) return null;
    const rows = [...table.tBodies[0].rows];
    let [row, column] = [rows.indexOf(cell.parentElement) + step[0], cell.cellIndex + step[1]];
    for (; rows[row]?.cells[column]; row += step[0], column += step[1]) {
      const link = rows[row].cells[column].querySelector("a");
      if (link) return link;
    }
    return null;
  };

  const close = (button) => {
    button.setAttribute("aria-expanded", "false");
    button.closest("tr").nextElementSibling.remove();
  };

  const open = (button) => {
    const row = button.closest("tr");
    const place = document.createElement("tr");
    place.className = "command";
    const cell = place.insertCell();
    cell.colSpan = row.cells.length;
    const code = cell.appendChild(document.createElement("code"));
    code.textContent = button.dataset.command;
    const said = cell.appendChild(document.createElement("span"));
    said.className = "faint";
    said.setAttribute("role", "status");
    row.after(place);
    button.setAttribute("aria-expanded", "true");
    // Pages from a disk may be refused the clipboard; the command is there to be selected.
    navigator.clipboard?.writeText(button.dataset.command).then(
      () => { said.textContent = " copied"; },
      () => {},
    );
  };

  for (const table of document.querySelectorAll("table.data")) {
    const buttons = buttonsOf(table);
    rove(buttons, alongLine(buttons));
    table.addEventListener("click", (event) => {
      const button = event.target.closest("td.again > button");
      if (button) (button.getAttribute("aria-expanded") === "true" ? close : open)(button);
    });
  }
  for (const table of document.querySelectorAll("table[data-grid]")) {
    rove([...table.querySelectorAll("tbody a")], alongGrid(table));
  }

  // What is wider than its place is scrolled by keys as well. An observer asks for no layout of its
  // own, which would double the time to the first view of a long page.
  const reach = new ResizeObserver((entries) => {
    for (const { target } of entries) {
      if (target.scrollWidth > target.clientWidth + 1) target.tabIndex = 0;
      else target.removeAttribute("tabindex");
    }
  });
  for (const box of document.querySelectorAll(".scroll, .card, nav > div")) reach.observe(box);

  // A link into a closed part opens it.
  const unfold = () => {
    const target = location.hash && document.getElementById(location.hash.slice(1));
    for (let part = target; part; part = part.parentElement) {
      if (part.tagName === "DETAILS") part.open = true;
    }
  };
  addEventListener("hashchange", unfold);
  unfold();
  document.documentElement.classList.add("scripted");

  // What was left out for the first view is laid out when there is time, from the top: pictures of
  // the whole page, and lengths of the scroll bar, are then right.
  const settle = (sections) => {
    const [next, ...rest] = sections;
    if (!next) return;
    next.style.contentVisibility = "visible";
    requestIdleCallback(() => settle(rest));
  };
  addEventListener("load", () => {
    requestIdleCallback(() => settle([...document.querySelectorAll("main > section")]));
  });
})();
