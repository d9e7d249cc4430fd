/** Light or dark, before the first paint: this file is loaded in the head, ahead of everything else. */

const stored = localStorage.getItem("openrois.theme");
if (stored === "light" || stored === "dark") document.documentElement.dataset["theme"] = stored;
