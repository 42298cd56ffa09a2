// One small box for everything that is told under the pointer or on focus.

const tip = make("div", { class: "tip", role: "tooltip", id: "tip", hidden: true });

function showTip(lines, x, y) {
  tip.replaceChildren(...lines.map((line, i) => make(i ? "div" : "strong", {}, line)));
  tip.hidden = false;
  const { offsetWidth: width, offsetHeight: height } = tip;
  tip.style.left = `${Math.max(4, Math.min(x + 14, document.documentElement.clientWidth - width - 8))}px`;
  tip.style.top = `${y + 16 + height > window.innerHeight ? Math.max(4, y - height - 10) : y + 16}px`;
}

function hideTip() {
  tip.hidden = true;
}

function tellTerm(event) {
  const target = event.target.closest?.("[data-tip]");
  if (!target) return;
  const box = target.getBoundingClientRect();
  showTip([target.textContent, target.dataset.tip], box.left - 14, box.bottom - 10);
  target.setAttribute("aria-describedby", "tip");
}

function startTips() {
  document.body.append(tip);
  for (const name of ["mouseover", "focusin"]) document.addEventListener(name, tellTerm);
  for (const name of ["mouseout", "focusout"]) {
    document.addEventListener(name, (event) => { if (event.target.closest?.("[data-tip]")) hideTip(); });
  }
  document.addEventListener("keydown", (event) => { if (event.key === "Escape") hideTip(); });
  document.addEventListener("scroll", hideTip, { passive: true });
}
