"use strict";

/** Open whatever hides the place that the address names. */
function reveal() {
  const place = location.hash.length > 1 && document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (!place) return;
  for (let part = place; part; part = part.parentElement) if (part.matches("details")) part.open = true;
  const folded = place.querySelector(":scope > details.folded");
  if (folded) folded.open = true;
  place.scrollIntoView();
}
if (matchMedia("(max-width: 40rem)").matches) for (const part of document.querySelectorAll("details.part")) part.open = false;
addEventListener("hashchange", reveal);
addEventListener("click", (event) => {
  const link = event.target.closest('a[href^="#"]');
  if (link && link.hash === location.hash) reveal();
});
reveal();

for (const index of document.querySelectorAll("nav details")) {
  index.addEventListener("click", (event) => { if (event.target.closest("a")) index.open = false; });
  document.addEventListener("keydown", (event) => { if (event.key === "Escape") index.open = false; });
  document.addEventListener("click", (event) => { if (!index.contains(event.target)) index.open = false; });
}

/** What a cell is sorted by: the last number before an interval, as of "0 -> 86 %"; null where it has none. */
function keyOf(row, column) {
  const cell = row.cells[column];
  if (!("key" in cell.dataset)) return cell.textContent.trim();
  const numbers = cell.dataset.key.split("[")[0].match(/-?[\d.,]+(?:e[+-]?\d+)?/g);
  return numbers && Number(numbers.at(-1).replaceAll(",", ""));
}

function sort(table, column, down) {
  const sign = down ? -1 : 1;
  const rows = [...table.tBodies[0].rows];
  rows.sort((one, other) => {
    const [a, b] = [keyOf(one, column), keyOf(other, column)];
    if (a === null || b === null) return (a === null) - (b === null);
    return sign * (typeof a === "number" ? a - b : a.localeCompare(b));
  });
  table.tBodies[0].append(...rows);
}

const table = document.querySelector(".overview table");
if (table) {
  const headings = [...table.tHead.rows[0].cells];
  headings.forEach((heading, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = heading.textContent;
    heading.replaceChildren(button);
    button.addEventListener("click", () => {
      const down = heading.getAttribute("aria-sort") === "ascending";
      for (const other of headings) other.removeAttribute("aria-sort");
      heading.setAttribute("aria-sort", down ? "descending" : "ascending");
      sort(table, column, down);
    });
  });
  const form = document.querySelector(".filter");
  const filter = () => {
    const words = form.words.value.toLowerCase().split(/\s+/).filter(Boolean);
    const rows = [...table.tBodies[0].rows];
    for (const row of rows) {
      const text = row.textContent.toLowerCase();
      row.hidden = !(words.every((word) => text.includes(word)) && [row.dataset.answer, ""].includes(form.answer.value));
    }
    form.querySelector("output").value = `${rows.filter((row) => !row.hidden).length} of ${rows.length}`;
  };
  if (form) {
    form.addEventListener("input", filter);
    form.addEventListener("submit", (event) => event.preventDefault());
    form.hidden = false;
    filter();
  }
}

/** A button that copies a command. */
for (const text of document.querySelectorAll("pre.command")) {
  const around = document.createElement("div"), button = document.createElement("button");
  around.className = "copied";
  text.replaceWith(around);
  Object.assign(button, { type: "button", textContent: "Copy" });
  button.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(text.textContent);
      button.textContent = "Copied";
    } catch {  // a browser may forbid it: the text is selected instead
      getSelection().selectAllChildren(text);
      button.textContent = "Selected";
    }
    setTimeout(() => { button.textContent = "Copy"; }, 2_000);
  });
  around.append(text, button);
}

/** The last picture of an episode, and on request all of them, one after the other. */
for (const still of document.querySelectorAll(".still.pictures")) {
  const films = [...still.querySelectorAll("canvas")].map((canvas) => {
    const image = document.getElementById(canvas.dataset.strip), count = Number(canvas.dataset.count);
    const show = (at) => {
      const width = image.naturalWidth / count, height = image.naturalHeight;
      Object.assign(canvas, { width, height });
      canvas.style.aspectRatio = `${width} / ${height}`;
      canvas.getContext("2d").drawImage(image, at * width, 0, width, height, 0, 0, width, height);
    };
    return { image, count, show };
  });
  const last = () => films.forEach(({ image, count, show }) => image.decode().then(() => show(count - 1)));
  const most = Math.max(...films.map(({ count }) => count));
  still.querySelector("button").addEventListener("click", () => {
    let at = 0;
    const timer = setInterval(() => {
      films.forEach(({ count, show }) => show(Math.min(at, count - 1)));
      at += 1;
      if (at >= most) clearInterval(timer);
    }, 350);
  });
  still.hidden = false;
  last();
}

/** The file that a button carries, unpacked. */
async function save({ dataset }) {
  const packed = Uint8Array.from(atob(dataset.content), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const file = new Blob([await new Response(stream).arrayBuffer()], { type: dataset.kind });
  const link = document.createElement("a");
  link.href = URL.createObjectURL(file);
  link.download = dataset.name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
for (const button of document.querySelectorAll("button[data-content]")) {
  button.addEventListener("click", () => save(button));
  button.hidden = false;
}
