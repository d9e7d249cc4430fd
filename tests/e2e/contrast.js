// Returns the texts on the page, and for each the ratio of contrast to what lies behind it (WCAG 2.2, 1.4.3).
// Left out: what cannot be used now, what is hidden, and what stands upon the picture.
() => {
  const context = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
  const painted = (layers) => {
    context.clearRect(0, 0, 1, 1);
    for (const { colour, opacity } of layers) {
      context.globalAlpha = opacity;
      context.fillStyle = colour;
      context.fillRect(0, 0, 1, 1);
    }
    return [...context.getImageData(0, 0, 1, 1).data];
  };
  const linear = (value) => {
    const part = value / 255;
    return part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4;
  };
  const luminance = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  const ratio = (one, other) => {
    const [dark, light] = [luminance(one), luminance(other)].sort((a, b) => a - b);
    return (light + 0.05) / (dark + 0.05);
  };
  const ancestors = (element) => (element ? [...ancestors(element.parentElement), element] : []);

  const found = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const element = node.parentElement;
    if (node.data.trim() === "" || !element.checkVisibility({ visibilityProperty: true, opacityProperty: true })) continue;
    if (element.closest(":disabled, .visually-hidden, .skip, [data-testid=stage], option, dialog:not([open])")) continue;
    const chain = ancestors(element);
    const layers = chain.map((each) => ({ colour: getComputedStyle(each).backgroundColor, opacity: 1 }));
    const behind = painted([{ colour: "white", opacity: 1 }, ...layers]);
    const opacity = chain.reduce((product, each) => product * Number(getComputedStyle(each).opacity), 1);
    const colour = `rgb(${behind.slice(0, 3)})`;
    const text = painted([{ colour, opacity: 1 }, { colour: getComputedStyle(element).color, opacity }]);
    found.push({ text: node.data.trim().slice(0, 40), of: element.className || element.tagName, ratio: ratio(text, behind) });
  }
  return found;
};
