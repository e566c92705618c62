// How the search of the site ranks what it finds: chapters before the pages of the
// library, whose names of modules would else come first.  But who asks for one thing by
// name, `mkt.track`, `SSD.step`, `T09-b`, `lab 3` or `chapter 5`, has it first.  Sphinx
// reads this into its own search; the numbers but for `score` are Sphinx's.

const FIRST = 1000;

// Whether a result is just what was asked for.
function named(asked, page, title, anchor) {
  if (/^[tnc]\d\d-[a-z]$/i.test(asked)) return page === "claims";
  const [, kind, number] = /^(lab|chapter) (\d+)$/i.exec(asked) ?? [];
  if (kind?.toLowerCase() === "lab") return page.includes(`/lab_${number}_`);
  if (kind) return page.startsWith(`${number.padStart(2, "0")}_`);
  if (title === asked || (asked.includes(".") && title.endsWith(`.${asked}`)))
    return true;
  // A public name: something in a module of the library, but for those of the course.
  const [, name] = /^mkt\.(\w+)$/.exec(asked) ?? [];
  if (!name || !page.startsWith("api/") || page.startsWith("api/mkt.course"))
    return false;
  const inModule = new RegExp(`\\.[a-z_0-9]+\\.${name}$`);
  return inModule.test(title) && !anchor.startsWith("#module-");
}

var Scorer = {
  score: ([page, title, anchor, , score]) => {
    const asked = new URLSearchParams(location.search).get("q")?.trim() ?? "";
    if (named(asked, page, title, anchor ?? "")) return score + FIRST;
    return page.startsWith("api/") ? score - 100 : score;
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
