for (const pictures of document.querySelectorAll("[data-swipe]")) {
  const make = (name, parent, set = {}) => Object.assign(parent.appendChild(document.createElement(name)), set);
  const views = document.createElement("div");
  views.className = "views";
  pictures.before(views);
  const swipe = document.createElement("div");
  swipe.className = "swipe";
  swipe.hidden = true;
  pictures.after(swipe);

  const stack = make("div", swipe, { className: "stack" });
  for (const kind of ["reference", "picture"]) {
    const image = stack.appendChild(pictures.querySelector(`.${kind} img`).cloneNode());
    image.draggable = false;
  }
  const slider = make("input", swipe, { type: "range", min: 0, max: 100, value: 50 });
  slider.setAttribute("aria-label", "where the reference ends and the picture begins, in percent");
  const ends = make("div", swipe, { className: "ends" });
  make("span", ends, { textContent: "reference" });
  make("span", ends, { textContent: "picture" });

  const put = () => stack.style.setProperty("--at", `${slider.value}%`);
  const drag = event => {
    if (event.type === "pointermove" && !event.buttons) return;
    const { left, width } = stack.getBoundingClientRect();
    slider.value = 100 * (event.clientX - left) / width;
    put();
  };
  slider.oninput = put;
  stack.onpointerdown = drag;
  stack.onpointermove = drag;
  put();

  const buttons = [["side by side", pictures], ["swipe", swipe]].map(([textContent, shown]) => {
    const button = make("button", views, { textContent, type: "button" });
    button.onclick = () => {
      for (const view of [pictures, swipe]) view.hidden = view !== shown;
      for (const other of buttons) other.setAttribute("aria-pressed", other === button);
    };
    button.setAttribute("aria-pressed", shown === pictures);
    return button;
  });
}
