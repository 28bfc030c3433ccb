// Widgets ask for their formulas as MathJax 2 wanted to be asked; the book has MathJax 3, which they then stumble over.
window.addEventListener("load", () => {
  const { MathJax } = window;
  if (MathJax && !MathJax.Hub) MathJax.Hub = { Queue: ([, , element]) => MathJax.typesetPromise?.([element]) };
}, { capture: true, once: true });
