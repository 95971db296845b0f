"use strict";

// Selection of charts: a section shows the charts whose data equal the values of its select elements.
for (const section of document.querySelectorAll(".choices")) {
  const selects = [...section.querySelectorAll("select[data-choice]")];
  const show = () => {
    for (const charts of section.querySelectorAll(".pair")) {
      charts.hidden = selects.some((s) => charts.dataset[s.dataset.choice] !== s.value);
    }
  };
  for (const select of selects) select.addEventListener("change", show);
  // If the user returns to the page, a browser keeps the values of the select elements.
  show();
}
