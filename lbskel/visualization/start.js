// Unpacks the data and runs what takes long, the packed programs, when the picture of the first view is on the screen.
"use strict";
(function () {
  async function unpack(element) {
    const letters = atob(element.textContent);
    const bytes = new Uint8Array(letters.length);
    for (let k = 0; k < letters.length; k += 1) bytes[k] = letters.charCodeAt(k); // a call for each would take longer
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).text();
  }

  // plotly reads its drawings of text back, which takes long where a graphics processor has them
  const getContext = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    return getContext.call(this, kind, kind === "2d" ? { willReadFrequently: true, ...options } : options);
  };

  async function start() {
    performance.mark("picture");
    const packed = Array.from(document.querySelectorAll("script[data-packed]"));
    const texts = await Promise.all(packed.map(unpack));
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
