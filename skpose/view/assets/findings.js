// The finding in the address is played; a click on another one loads the page again.

const inAddress = () => new URLSearchParams(location.hash.slice(1)).get("finding");
const chosen = inAddress() ?? Object.keys(data.clips)[0];
data.motions = [data.clips[chosen] ?? Object.values(data.clips)[0]];
element(`finding-${chosen}`)?.setAttribute("aria-current", "true");
addEventListener("hashchange", () => (inAddress() ?? chosen) === chosen || location.reload());
