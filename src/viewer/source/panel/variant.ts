// The switch on the 3D view where two archives are open: before, after, what changed. In: the
// state. Out: the state.

import type { Partners } from "../change";
import { byId } from "../dom";
import type { Store, Variant } from "../state";

export class VariantPanel {
  private readonly box = byId("variant", HTMLElement);
  private readonly radios = [...document.querySelectorAll<HTMLInputElement>('input[name="variant"]')];

  constructor(private readonly store: Store) {
    for (const radio of this.radios) {
      radio.addEventListener("change", () => {
        const variant = radio.value as Variant;
        // A range by hand is one of values or one of changes.
        const other = (variant === "change") !== (store.state.variant === "change");
        store.set({ variant, ...(other ? { range: null } : {}) });
      });
    }
    store.subscribe(() => this.refresh());
  }

  /** Two archives are on the page; `partners` where receivers can be compared. */
  open(partners: Partners | null): void {
    this.box.hidden = false;
    document.body.dataset["variants"] = "two";
    for (const radio of this.radios) if (radio.value === "change") radio.disabled = partners === null;
    this.refresh();
  }

  close(): void {
    this.box.hidden = true;
    delete document.body.dataset["variants"];
  }

  private refresh(): void {
    for (const radio of this.radios) radio.checked = radio.value === this.store.state.variant;
  }
}
