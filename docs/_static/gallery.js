// Choices above the galleries of tasks: which robots, and what their experts do. A still plays its
// film while the pointer or the focus is on its card, or after a tap.
const cards = [...document.querySelectorAll(".gallery > [data-robots]")];
const words = (card, key) => card.dataset[key].split(" ").filter(Boolean);

function show(selects) {
  for (const card of cards) {
    card.hidden = selects.some((select) => select.value && !words(card, select.name).includes(select.value));
  }
  for (const section of new Set(cards.map((card) => card.closest("section")))) {
    section.hidden = cards.every((card) => card.hidden || card.closest("section") !== section);
  }
}

function choice(key, label) {
  const select = document.createElement("select");
  select.name = key;
  const found = [...new Set(cards.flatMap((card) => words(card, key)))].sort();
  for (const word of ["", ...found]) {
    select.add(new Option(word || "any", word));
  }
  const line = document.createElement("label");
  line.append(`${label} `, select);
  return line;
}

if (cards.length > 3) {
  const bar = document.createElement("div");
  bar.className = "gallery-choices";
  bar.append(choice("robots", "robot"), choice("skills", "skill"));
  const selects = [...bar.querySelectorAll("select")];
  bar.addEventListener("change", () => show(selects));
  cards[0].closest("section").before(bar);
}

for (const card of cards) {
  const picture = card.querySelector("img");
  const still = picture.src;
  const film = still.replace(/\.webp$/, ".gif");
  const play = (plays) => {
    const wanted = plays ? film : still;
    if (picture.src !== wanted) picture.src = wanted;
  };
  card.addEventListener("pointerenter", (event) => event.pointerType === "mouse" && play(true));
  card.addEventListener("pointerleave", (event) => event.pointerType === "mouse" && play(false));
  card.addEventListener("focusin", () => play(true));
  card.addEventListener("focusout", () => play(false));
  picture.addEventListener("click", (event) => event.pointerType !== "mouse" && play(picture.src === still));
}
