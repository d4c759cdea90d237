// Plays a day: the clock goes on when the view has followed.

import { byId } from "../dom";
import type { Session } from "../session";
import type { Store } from "../state";

/** Shortest time that a picture stands, ms. */
const FRAME = 120;
const STILL_FRAME = 1000;

export class Player {
  private readonly button = byId("play", HTMLButtonElement);
  private turn = 0;

  constructor(
    private readonly store: Store,
    private readonly opened: () => { session: Session; seeing(): Promise<void> } | null,
  ) {
    this.button.addEventListener("click", () => (this.playing ? this.stop() : void this.play()));
    store.subscribe((changed) => {
      if (changed.has("sunBy") || (changed.has("show") && store.state.show !== "moment")) this.stop();
    });
  }

  get playing(): boolean {
    return this.button.getAttribute("aria-pressed") === "true";
  }

  stop(): void {
    this.turn += 1;
    this.button.setAttribute("aria-pressed", "false");
    this.button.textContent = "Play the day";
  }

  private async play(): Promise<void> {
    const opened = this.opened();
    if (!opened) return;
    const { session } = opened;
    const turn = ++this.turn;
    // With reduced motion the clock goes slowly, an hour at a time.
    const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    const step = this.store.state.light === "weather" || calm ? 60 : 10;
    if (this.store.state.show !== "moment") this.store.set({ show: "moment", range: null });
    this.button.setAttribute("aria-pressed", "true");
    this.button.textContent = "Stop";
    while (turn === this.turn) {
      const shown = performance.now();
      const { state } = this.store;
      let minutes = (state.minutes + step) % 1440;
      // Nights are left out, but not if there is no sun all day.
      for (let tries = 0; tries < 1440 / step; tries++) {
        if ((await session.engine.sun(state.dayOfYear, minutes)).altitude > -1) break;
        minutes = (minutes + step) % 1440;
      }
      if (turn !== this.turn) return;
      this.store.set({ minutes: Math.floor(minutes / 10) * 10 });
      await opened.seeing();
      const left = (calm ? STILL_FRAME : FRAME) - (performance.now() - shown);
      if (left > 0) await new Promise((resolve) => setTimeout(resolve, left));
    }
  }
}
