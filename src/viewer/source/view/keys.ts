// Keyboard and pointer on the 3D view. Dragging and pinching belong to three's orbit; this tells
// clicks from drags and moves by keys.

import type { Stage } from "./stage";

const TURN = Math.PI / 36;
/** Movement below which a pointer press is a click, page pixels. */
const STILL = 5;

/** `pick` gets a place on the canvas in page pixels. */
export function listenToView(stage: Stage, pick: (x: number, y: number) => void): void {
  const { canvas } = stage;
  let pressed: { x: number; y: number; id: number } | null = null;
  canvas.addEventListener("pointerdown", (event) => {
    pressed = event.isPrimary && event.button === 0 ? { x: event.clientX, y: event.clientY, id: event.pointerId } : null;
  });
  canvas.addEventListener("pointerup", (event) => {
    if (pressed?.id !== event.pointerId) return;
    if (Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) < STILL) {
      const box = canvas.getBoundingClientRect();
      pick(event.clientX - box.left, event.clientY - box.top);
    }
    pressed = null;
  });
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const shift = event.shiftKey;
    switch (event.key) {
      case "ArrowLeft": shift ? stage.pan(-0.05, 0) : stage.orbit(-TURN, 0); break;
      case "ArrowRight": shift ? stage.pan(0.05, 0) : stage.orbit(TURN, 0); break;
      case "ArrowUp": shift ? stage.pan(0, 0.05) : stage.orbit(0, TURN); break;
      case "ArrowDown": shift ? stage.pan(0, -0.05) : stage.orbit(0, -TURN); break;
      case "+": case "=": stage.zoom(1 / 1.15); break;
      case "-": case "_": stage.zoom(1.15); break;
      case "Home": stage.goHome(); break;
      case "Enter": case " ": pick(canvas.clientWidth / 2, canvas.clientHeight / 2); break;
      default: return;
    }
    event.preventDefault();
  });
}
