// How the search of the site ranks what it finds: chapters before the pages of the
// library, whose names of modules would else come first.  Sphinx reads it into its own
// search; the numbers but for `score` are Sphinx's.

var Scorer = {
  score: ([page, , , , score]) => (page.startsWith("api/") ? score - 100 : score),
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
