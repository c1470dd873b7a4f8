/* Tables and output of programs that are wider than the page fade at the sides where they go on, and scroll by keys. */
"use strict";
for (const part of document.querySelectorAll("article table, article .highlight-text pre, article .cell_output pre")) {
  const update = () => {
    const left = part.scrollLeft, right = part.scrollWidth - part.clientWidth - left;
    part.classList.toggle("more-left", left > 1);
    part.classList.toggle("more-right", right > 1);
    if (left + right > 1) part.tabIndex = 0;
    else part.removeAttribute("tabindex");
  };
  part.addEventListener("scroll", update, { passive: true });
  new ResizeObserver(update).observe(part);
}
