// Tabs, by pointer and by arrow keys.

import { byId } from "./dom.js";

// `onShow`: called with the name of the tab that is shown.
export const tabs = (names, onShow) => {
  const buttons = names.map((name) => byId(`tab-${name}`));
  const show = (name) => {
    names.forEach((other, index) => {
      const isShown = other === name;
      byId(other).hidden = !isShown;
      buttons[index].setAttribute("aria-selected", String(isShown));
      buttons[index].tabIndex = isShown ? 0 : -1;
    });
    onShow(name);
  };
  buttons.forEach((button, index) => {
    button.addEventListener("click", () => show(names[index]));
    button.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!way) return;
      const other = (index + way + names.length) % names.length;
      show(names[other]);
      buttons[other].focus();
    });
  });
  show(names[0]);
  return { show };
};
