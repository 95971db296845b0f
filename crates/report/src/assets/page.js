"use strict";

// Choices among charts: a section shows those whose data agree with its selects.
for (const section of document.querySelectorAll(".choices")) {
  const selects = [...section.querySelectorAll("select[data-choice]")];
  const show = () => {
    for (const charts of section.querySelectorAll(".pair")) {
      charts.hidden = selects.some((s) => charts.dataset[s.dataset.choice] !== s.value);
    }
  };
  for (const select of selects) select.addEventListener("change", show);
  // A browser that comes back to the page keeps the selects as they were.
  show();
}
