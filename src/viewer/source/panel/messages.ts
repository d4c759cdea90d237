// Messages about failures on the page, with a hint. In: errors of the engine. Texts are shown as
// text, whatever they hold.

import { byId, el } from "../dom";

interface Told {
  kind: string;
  message: string;
  hint: string;
}

function told(error: unknown): Told {
  if (typeof error === "object" && error !== null) {
    const found = error as Partial<Record<keyof Told, unknown>>;
    const text = (value: unknown): string => (typeof value === "string" ? value : "");
    return { kind: text(found.kind) || "other", message: text(found.message), hint: text(found.hint) };
  }
  return { kind: "other", message: String(error), hint: "" };
}

const ADVICE: Record<string, { what: string; todo: string }> = {
  "not-found": { what: "There is no archive at this address.", todo: "Check the address, or open the file from this computer." },
  network: { what: "The archive could not be loaded.", todo: "Check the connection and that the server lets other sites read it (CORS), then reload the page." },
  "no-archive": { what: "This file is not an archive of heliotile.", todo: "Open a .helio file, as `heliotile run` and `heliotile build` write them." },
  version: { what: "This page cannot read the format version of this archive.", todo: "Use the page of the program that wrote the archive, or build the archive again." },
  cut: { what: "This archive is cut off: its end is missing.", todo: "Copy or download it again; `heliotile archive verify` checks whether it is complete." },
  damaged: { what: "A part of this archive is damaged.", todo: "`heliotile archive verify` lists what is damaged, `heliotile archive repair` traces it again." },
  "other-place": { what: "The two archives cannot be compared: they lie at different places or use different coordinate systems.", todo: "Choose an archive of the same site." },
  "too-large": { what: "The server sends only whole files, and this one is too large for that.", todo: "Use a server that answers byte ranges (`heliotile view` does), or open the file from this computer." },
};

const MOST = 4;

export class Messages {
  private readonly box = byId("messages", HTMLElement);
  private readonly damage = byId("damage", HTMLElement);
  private readonly damages = byId("damage-list", HTMLElement);
  private readonly damaged = new Set<string>();

  /**
   * Shows an error. `what` names the action that failed: "opening x.epw". The hint is the page's
   * own if it knows the kind of error, else the engine's.
   */
  error(what: string, error: unknown): void {
    const { kind, message, hint } = told(error);
    const advice = ADVICE[kind];
    const lines = [advice ? advice.what : `Failed: ${what}.`, message ? `${what[0]!.toUpperCase()}${what.slice(1)}: ${message}.` : "", advice?.todo ?? hint];
    this.tell(lines.filter((line) => line !== ""), true, kind);
  }

  tell(lines: string[], bad: boolean, kind = "note"): void {
    const close = el("button", { type: "button", class: "bare", "aria-label": "Close this message", text: "×" });
    const message = el(
      "div",
      { class: bad ? "message bad" : "message", role: bad ? "alert" : "status", "data-kind": kind },
      el("div", {}, ...lines.map((line) => el("p", { text: line }))),
      close,
    );
    close.addEventListener("click", () => message.remove());
    // A repeated message, as of the weather of each part, stands there once.
    for (const former of [...this.box.children]) if (former.textContent === message.textContent) former.remove();
    this.box.append(message);
    while (this.box.children.length > MOST) this.box.firstElementChild?.remove();
  }

  clear(): void {
    this.box.replaceChildren();
    this.damages.replaceChildren();
    this.damaged.clear();
    this.damage.hidden = true;
  }

  /**
   * A part that cannot be read, of an archive that is called so where there are two: it is listed
   * once, the rest goes on.
   */
  lost(tile: number, error: unknown, archive: string): void {
    const message = `${archive === "" ? "" : `${archive}: `}${typeof error === "string" ? error : told(error).message}`;
    if (this.damaged.has(message)) return;
    if (this.damaged.size === 0) {
      this.tell([`Tile ${tile} cannot be shown: ${message}`, "The page shows the rest, and lists all damaged parts under Site. `heliotile archive repair` traces them again."], true, "damaged");
    }
    this.damaged.add(message);
    this.damage.hidden = false;
    this.damages.append(el("li", { text: message }));
  }
}
