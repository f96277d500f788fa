// What a page shows, in the fragment of its address: a link that opens the same.

const BETWEEN_WRITES = 400; // ms between two writes; browsers permit some hundred in half a minute
const OWN_ADDRESS = location.protocol !== "about:"; // a page inside of a notebook has none

class Link {
  /** `values()` are words and numbers by name, null for what is as usual; `restore(found)` takes a table of words. */
  constructor(values, restore) {
    Object.assign(this, { values, restore, waiting: 0 });
    addEventListener("hashchange", () => this.words.size && restore(this.words));
    listenForCopy(this);
  }

  get words() {
    const names = Object.keys(this.values());
    return new Map([...new URLSearchParams(location.hash.slice(1))].filter(([name]) => names.includes(name)));
  }

  get address() {
    const given = Object.entries(this.values()).filter(([, value]) => value !== null);
    const text = given.map(([name, value]) => `${name}=${encodeURIComponent(value).replaceAll("%2C", ",")}`).join("&");
    return location.href.split("#")[0] + (text && `#${text}`);
  }

  /** Write soon what the page shows into its address, as no new entry of the history. */
  write() {
    if (this.waiting || !OWN_ADDRESS) return;
    this.waiting = setTimeout(() => {
      this.waiting = 0;
      if (this.address !== location.href) history.replaceState(history.state, "", this.address);
    }, BETWEEN_WRITES);
  }
}

function numbersIn(word, count) {
  const numbers = (word ?? "").split(",").map((part) => (part.trim() ? Number(part) : NaN));
  return numbers.length === count && numbers.every(Number.isFinite) ? numbers : null;
}

const clamp = (value, low, high) => Math.max(low, Math.min(high, value));

/** Numbers as a word, without digits that nobody sees. */
const wordOf = (...numbers) => numbers.map((number) => Number(number.toFixed(4))).join(",");

const preciseWord = (...numbers) => numbers.map((number) => Number(number.toPrecision(6))).join(",");

/** A camera as a word, and back: another word leaves it as it is. */
const cameraWord = ({ azimuth, elevation, zoom, shift }) => wordOf(azimuth, elevation, zoom, ...shift);
function restoreCamera(camera, word) {
  const numbers = numbersIn(word, 5);
  if (!numbers) return;
  const [azimuth, elevation, zoom, ...shift] = numbers;
  Object.assign(camera, {
    azimuth: azimuth % (2 * Math.PI), elevation: clamp(elevation, -1.55, 1.55), zoom: clamp(zoom, 0.05, 50),
    shift: shift.map((share) => clamp(share, -10, 10)),
  });
}

function setControl(control, word, usual) {
  if (control.type === "checkbox") control.checked = word === "1" || word === "0" ? word === "1" : usual;
  else if (control.type === "number") control.value = numbersIn(word, 1) ? clamp(word, 0, control.max) : usual;
  else control.value = [...control.options].some(({ value }) => value === word) ? word : usual;
}

/** Let a button copy the link, or show it where the browser does not permit that. */
function listenForCopy(link) {
  const [button, said] = [element("copy"), element("said")];
  button.hidden = !OWN_ADDRESS;
  button.addEventListener("click", async () => {
    const { address } = link;
    try {
      await navigator.clipboard.writeText(address);
    } catch { // no clipboard, or not permitted, as on pages without https
      return (said.textContent = address);
    }
    said.textContent = "Copied.";
  });
}
