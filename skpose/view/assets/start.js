// Unpack the program of a page, and start it: an element that the policy of the page admits by its digest.

{
  const { program } = document.currentScript.dataset;
  if (typeof DecompressionStream === "undefined") {
    const failure = document.getElementById("failure");
    Object.assign(failure, { textContent: "This page needs a browser of 2023 or later.", hidden: false });
  } else {
    const compressed = Uint8Array.from(atob(program), (character) => character.charCodeAt(0));
    const stream = new Blob([compressed]).stream().pipeThrough(new DecompressionStream("deflate"));
    new Response(stream).text().then((text) => {
      const script = Object.assign(document.createElement("script"), { type: "module", textContent: text });
      document.body.append(script);
    });
  }
}
