// Files from this computer: pickers and dropping. Their names, and the engine, tell their kinds.

import { byId } from "../dom";

interface Takers {
  onArchive(file: File): void;
  onAfter(file: File): void;
  onWeather(file: File): void;
  onClouds(file: File): void;
}

export function listenForFiles({ onArchive, onAfter, onWeather, onClouds }: Takers): void {
  const archive = byId("file-archive", HTMLInputElement);
  const after = byId("file-after", HTMLInputElement);
  const weather = byId("file-weather", HTMLInputElement);
  const clouds = byId("file-clouds", HTMLInputElement);
  const drop = byId("drop", HTMLElement);
  for (const id of ["open-archive", "welcome-open"]) byId(id, HTMLButtonElement).addEventListener("click", () => archive.click());
  byId("open-after", HTMLButtonElement).addEventListener("click", () => after.click());
  byId("open-weather", HTMLButtonElement).addEventListener("click", () => weather.click());
  byId("open-clouds", HTMLButtonElement).addEventListener("click", () => clouds.click());
  for (const [input, take] of [[archive, onArchive], [after, onAfter], [weather, onWeather], [clouds, onClouds]] as const) {
    input.addEventListener("change", () => {
      const file = input.files?.[0];
      input.value = "";
      if (file) take(file);
    });
  }
  const isFile = (event: DragEvent): boolean => event.dataTransfer?.types.includes("Files") ?? false;
  addEventListener("dragover", (event) => {
    if (!isFile(event)) return;
    event.preventDefault();
    drop.hidden = false;
  });
  addEventListener("dragleave", (event) => {
    if (event.relatedTarget === null) drop.hidden = true;
  });
  addEventListener("drop", (event) => {
    if (!isFile(event)) return;
    event.preventDefault();
    drop.hidden = true;
    for (const file of event.dataTransfer?.files ?? []) (file.name.endsWith(".helio") ? onArchive : file.type.startsWith("image/") ? onClouds : onWeather)(file);
  });
}
