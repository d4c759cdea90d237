// In a narrow window the panels are one sheet at the bottom, and one part of it shows at a time.
// The tab that shows folds the sheet.

export function listenToTabs(): (part: string) => void {
  const tabs = [...document.querySelectorAll<HTMLButtonElement>("#tabs button")];
  const { body } = document;
  const show = (part: string): void => {
    body.dataset["tab"] = part;
    body.dataset["sheet"] = "open";
    for (const tab of tabs) tab.setAttribute("aria-current", String(tab.dataset["tab"] === part));
  };
  for (const tab of tabs) {
    tab.addEventListener("click", () => {
      const part = tab.dataset["tab"] ?? "show";
      if (part === body.dataset["tab"] && body.dataset["sheet"] === "open") body.dataset["sheet"] = "closed";
      else show(part);
    });
  }
  show("show");
  return show;
}
