// Unpacks the data and the programs, and runs these, which takes long, when the picture of the first view is on the screen.
"use strict";
(function () {
  async function unpack(element) {
    const letters = atob(element.textContent);
    const bytes = new Uint8Array(letters.length);
    for (let k = 0; k < letters.length; k += 1) bytes[k] = letters.charCodeAt(k); // a call for each would take longer
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).text();
  }

  // plotly reads its drawings of text back, which takes long where a graphics processor has them; it clears a canvas for
  // long titles before each, but has only symbols to draw here
  const getContext = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    if (kind === "2d" && this.width === 8192) { this.width = 512; this.height = 256; }
    return getContext.call(this, kind, kind === "2d" ? { willReadFrequently: true, ...options } : options);
  };

  const packed = Array.from(document.querySelectorAll("script[data-packed]"));
  const unpacked = Promise.all(packed.map(unpack));

  async function start() {
    performance.mark("picture");
    const texts = await unpacked;
    packed.forEach((element, number) => {
      if (element.type === "text/plain") {
        const script = document.createElement("script");
        script.textContent = texts[number];
        element.replaceWith(script);
      } else {
        element.textContent = texts[number];
      }
    });
  }

  const poster = document.getElementById("poster");
  const shown = poster ? poster.decode().catch(() => {}) : Promise.resolve();
  shown.then(() => requestAnimationFrame(() => setTimeout(start)));
})();
