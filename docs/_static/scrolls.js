// Tables and formulas that are wider than their box scroll in it: the keyboard reaches the box, and it has a name.
function nameBoxesThatScroll() {
  const counts = {};
  for (const box of document.querySelectorAll(".pst-scrollable-table-container, div.math")) {
    const scrolls = box.scrollWidth > box.clientWidth;
    const heading = box.closest("section").querySelector("h1, h2, h3, h4");
    const kind = `${box.matches(".math") ? "Formula" : "Table"}: ${heading.firstChild.textContent}`;
    counts[kind] = (counts[kind] ?? 0) + 1;
    const name = counts[kind] > 1 ? `${kind}, ${counts[kind]}` : kind;
    for (const [attribute, value] of Object.entries({ tabindex: 0, role: "region", "aria-label": name })) {
      if (scrolls) box.setAttribute(attribute, value);
      else box.removeAttribute(attribute);
    }
  }
}
addEventListener("load", nameBoxesThatScroll);
addEventListener("resize", nameBoxesThatScroll);
