/* Search as you type: a list below the search field of the sidebar, from the index and with the scores of the search
   page (searchindex.js, and scorer.js within language_data.js), which are loaded when the field is first used. */
"use strict";
(() => {
  const ROWS = 10;
  const root = document.documentElement.dataset.content_root;
  const field = document.querySelector("input.sidebar-search");
  if (!field) return;
  let index = null, loading = null, chosen = 0;

  const list = document.body.appendChild(document.createElement("div"));
  list.id = "search-list";
  list.hidden = true;
  list.setAttribute("role", "listbox");
  list.setAttribute("aria-label", "Pages found");
  const set = (element, pairs) => Object.entries(pairs).forEach(([name, value]) => element.setAttribute(name, value));
  set(field, { role: "combobox", "aria-controls": list.id, "aria-expanded": false, "aria-autocomplete": "list",
    autocomplete: "off", spellcheck: false, title: "/ or Ctrl-K" });

  const script = name => new Promise((done, failed) => {
    const element = document.createElement("script");
    Object.assign(element, { src: root + name, onload: done, onerror: failed });
    document.head.append(element);
  });

  /* The search page has loaded both files already. */
  async function load() {
    if (typeof Search !== "undefined" && Search._index) return (index = Search._index);
    if (typeof Scorer === "undefined") await script("_static/language_data.js");
    if (typeof Search === "undefined") window.Search = { setIndex: data => (index = data) };
    await script("searchindex.js");
    index ??= Search._index;
  }

  const words = text => text.toLowerCase().split(/[^\p{L}\p{N}_*]+/u).filter(Boolean);
  const files = found => found === undefined ? [] : [found].flat();

  const stems = new Map();
  const stem = word => stems.get(word) ?? stems.set(word, new Stemmer().stemWord(word)).get(word);

  /* Pages with a word, stemmed as in the index, or with a term that begins with it. */
  function pages(word, terms, whole, part) {
    const found = new Map();
    for (const [term, at] of Object.entries(terms)) {
      const score = term === word || term === stem(word) ? whole : word.length > 1 && term.startsWith(word) ? part : 0;
      if (score) files(at).forEach(file => found.set(file, Math.max(score, found.get(file) ?? 0)));
    }
    return found;
  }

  /* Rows [page, title, anchor, remark, score, file, kind], as the search page has them, the best first. */
  function search(query) {
    const asked = words(query).filter((word, at, all) => at === all.length - 1 || !stopwords.has(word)), rows = [];
    const add = (file, title, anchor, remark, score, kind) =>
      rows.push([index.docnames[file], title, anchor, remark, score, index.filenames[file], kind]);
    if (!asked.length) return rows;
    for (const [title, places] of Object.entries(index.alltitles)) {
      const own = words(title);
      const scores = asked.map(word =>
        own.some(other => other === word || stem(other) === stem(word)) ? Scorer.title :
        own.some(other => other.startsWith(word)) ? Scorer.partialTitle : 0);
      if (scores.includes(0)) continue;
      const share = asked.join("").length / own.join("").length;
      for (const [file, anchor] of places) {
        const isPage = index.titles[file] === title;
        add(file, title, anchor ? `#${anchor}` : "", isPage ? "" : index.titles[file],
          Math.min(...scores) + 5 * share + (isPage ? 3 : 0), "title");
      }
    }
    const name = query.trim().toLowerCase();
    for (const [prefix, objects] of Object.entries(index.objects)) {
      for (const [file, type, priority, anchor, own] of objects) {
        const full = `${prefix}.${own}`, last = own.split(".").at(-1);
        const asWritten = name.includes(".") ? [full, full.replace(/^gfmd\./, "")] : [last];
        const known = asWritten.map(other => other.toLowerCase());
        const score = known.includes(name) ? Scorer.objNameMatch
          : known.some(other => other.startsWith(name)) ? Scorer.objPartialMatch : 0;
        if (!score) continue;
        const place = anchor === "" ? full : anchor === "-" ? `${index.objnames[type][1]}-${full}` : anchor;
        const extra = (Scorer.objPrio[priority] ?? Scorer.objPrioDefault) + (name.includes(".") ? Scorer.title : 0);
        add(file, full, `#${place}`, index.objnames[type][2], score + extra, "object");
      }
    }
    const texts = asked.map(word => pages(word, index.terms, Scorer.term, Scorer.partialTerm));
    const titles = asked.map(word => pages(word, index.titleterms, Scorer.partialTitle, Scorer.term));
    index.titles.forEach((title, file) => {
      const scores = asked.map((_, at) => Math.max(texts[at].get(file) ?? 0, titles[at].get(file) ?? 0));
      if (!scores.includes(0)) add(file, title, "", "", Math.min(...scores), "text");
    });
    rows.forEach(row => (row[4] = Scorer.score(row)));
    rows.sort((one, other) => other[4] - one[4] || one[1].length - other[1].length);
    /* A page stands in the list once, with one more heading; the last places are for names of Python. */
    const times = {};
    const kept = rows.filter(([page, , anchor]) => {
      times[page] = (times[page] ?? 0) + 1;
      return times[page] === 1 || (anchor && times[page] < 3);
    });
    const first = kept.splice(0, ROWS - 2), names = kept.filter(row => row[6] === "object").slice(0, 2);
    return [...first, ...names, ...kept.filter(row => !names.includes(row))].slice(0, ROWS);
  }

  const close = () => {
    list.hidden = true;
    field.setAttribute("aria-expanded", false);
    field.removeAttribute("aria-activedescendant");
  };

  function choose(at) {
    const rows = [...list.children];
    chosen = (at + rows.length) % rows.length;
    rows.forEach((row, number) => row.setAttribute("aria-selected", number === chosen));
    rows[chosen].scrollIntoView({ block: "nearest" });
    field.setAttribute("aria-activedescendant", rows[chosen].id);
  }

  function row(address, title, remark) {
    const link = document.createElement("a");
    set(link, { href: address, role: "option", tabindex: -1, id: `search-row-${list.children.length}` });
    link.append(title);
    if (remark) link.appendChild(document.createElement("span")).textContent = remark;
    list.append(link);
  }

  function show() {
    const query = field.value.trim();
    if (!query || !index) return close();
    list.replaceChildren();
    for (const [page, title, anchor, remark] of search(query)) {
      row(root + page + DOCUMENTATION_OPTIONS.LINK_SUFFIX + anchor, title, remark);
    }
    row(`${root}search.html?q=${encodeURIComponent(query)}`, `Search the text for “${query}”`, "");
    const place = field.getBoundingClientRect();
    list.style.top = `${place.bottom + 4}px`;
    list.style.left = `${Math.max(place.left, 8)}px`;
    list.hidden = false;
    field.setAttribute("aria-expanded", true);
    choose(0);
  }

  const update = () => (loading ??= load()).then(show, () => (loading = null));

  field.addEventListener("focus", update);
  field.addEventListener("input", update);
  field.addEventListener("keydown", event => {
    if (event.isComposing) return;
    if (event.key === "Escape") {
      event.preventDefault();
      list.hidden ? field.blur() : close();
    } else if (!list.hidden && event.key === "Enter") {
      event.preventDefault();
      const to = list.children[chosen].href;
      close();
      window.location.assign(to);
    } else if (!list.hidden && event.key.match(/^Arrow(Up|Down)$/)) {
      event.preventDefault();
      choose(chosen + (event.key === "ArrowDown" ? 1 : -1));
    }
  });
  document.addEventListener("pointerdown", event => {
    if (event.target !== field && !list.contains(event.target)) close();
  });
  field.addEventListener("blur", event => list.contains(event.relatedTarget) || close());
  list.addEventListener("pointerdown", event => event.button || event.preventDefault());
  list.addEventListener("click", close);
  window.addEventListener("resize", () => list.hidden || show());

  /* Sphinx focuses the field on "/", too, but leaves a hidden sidebar hidden. */
  document.addEventListener("keydown", event => {
    const isTyped = event.target.closest?.("input, textarea, select, [contenteditable]");
    const isCalled = (event.ctrlKey || event.metaKey) && !event.altKey && !event.shiftKey && event.key === "k";
    if (!isCalled && (event.key !== "/" || isTyped || event.ctrlKey || event.metaKey || event.altKey)) return;
    event.preventDefault();
    if (field.getBoundingClientRect().right <= 0) document.getElementById("__navigation").checked = true;
    field.focus();
    field.select();
  });
})();
