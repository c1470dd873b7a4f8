/* The contents begin where the page stands in them. */
"use strict";
{
  const contents = document.querySelector(".sidebar-scroll"), entry = contents?.querySelector(".current-page");
  if (entry) {
    contents.scrollTop = entry.getBoundingClientRect().top - contents.getBoundingClientRect().top
      - contents.clientHeight / 2;
  }
}
