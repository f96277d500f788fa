// How a search orders pages, see _extensions/search_order.py.
var Scorer = {
  score: ([doc, , , , score]) => {
    const query = new URLSearchParams(location.search).get("q")?.trim();
    const pages = (typeof PAGES_OF_PARAMETERS === "object" && PAGES_OF_PARAMETERS[query]) || [];
    // More than a word in the text has, less than a name or a title.
    if (pages.includes(doc)) return score + 9 - pages.indexOf(doc) / pages.length;
    return doc === "changelog" ? score - 100 : score;
  },
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
