// uPlot as a module: the smallest file that it comes in is a script which sets a name of the window.
// A page that is written to a file has it already.

const load = (loaded, failed) => {
  const { href: src } = new URL("./vendor/uPlot.iife.min.js", import.meta.url);
  const script = document.createElement("script");
  Object.assign(script, { src, onload: loaded, onerror: failed });
  document.head.append(script);
};

if (!window.uPlot) await new Promise(load);

export const { uPlot } = window;
