/* Scores of the search page and of the search as you type (static/search.js): guides stand before reference pages,
   which name every word, and names of Python between titles and text. The numbers beside `score` are the defaults of
   Sphinx. */
var Scorer = {
    score: ([page, , , , score, , kind]) => {
        if (kind === "object") return score - 6;
        const reference = ["interface", "options", "columns", "together", "trust", "python-api", "theory", "benchmarks",
            "creep-peers", "any-load", "site/changelog"];
        const below = ["interface/", "python-api/", "theory/"];
        return reference.includes(page) || below.some(folder => page.startsWith(folder)) ? score - 12 : score;
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
