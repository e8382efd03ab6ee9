// Choices above the galleries of tasks: which robots, and what their experts do.
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
