/** The picture as large as the screen is. The whole page goes with it: STOP, text box and map lie upon it. */

import { byTestId } from "../dom/elements.ts";

/** Makes the button of the picture work. */
export function installFullscreen(): void {
  const button = byTestId("fullscreen", HTMLButtonElement);
  button.hidden = !document.fullscreenEnabled;
  button.addEventListener("click", toggleFullscreen);
  document.addEventListener("fullscreenchange", () => {
    const label = document.fullscreenElement ? "Leave full screen" : "Full screen";
    button.setAttribute("aria-label", label);
    button.title = `${label} (f)`;
  });
}

export function toggleFullscreen(): void {
  if (document.fullscreenElement) void document.exitFullscreen();
  else void document.documentElement.requestFullscreen().catch(() => undefined);
}
