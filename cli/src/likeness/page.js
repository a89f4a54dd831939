for (const box of document.querySelectorAll("details")) {
  const swipe = box.querySelector(".swipe");
  if (!swipe) continue;
  for (const button of box.querySelectorAll("button")) {
    button.onclick = () => {
      swipe.hidden = button.dataset.view !== "swipe";
      box.querySelector(".side").hidden = !swipe.hidden;
      box.querySelector(".side").style.display = swipe.hidden ? "" : "none";
    };
  }
  const over = swipe.querySelector(".over");
  swipe.querySelector("input").oninput = event => {
    over.style.clipPath = `inset(0 0 0 ${event.target.value}%)`;
  };
}
