// Runs what takes long, the scripts that are held as text, when the picture of the first view is on the screen.
"use strict";
(function () {
  const poster = document.getElementById("poster");
  const shown = poster ? poster.decode().catch(() => {}) : Promise.resolve();
  shown.then(() => requestAnimationFrame(() => setTimeout(() => {
    performance.mark("picture");
    document.querySelectorAll('script[type="text/plain"]').forEach((held) => {
      const script = document.createElement("script");
      script.textContent = held.textContent;
      held.replaceWith(script);
    });
  })));
})();
