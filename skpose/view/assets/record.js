// Files of what is seen: a picture (PNG), and a video (MP4 or WebM) or GIF of the loop.

const SHARP = 2; // pixels in a px of a picture, or as many as the display has
const [LONG_SIDE, LONG_SIDE_OF_VIDEO] = [800, 1280]; // px of a GIF, and of a video, at most
const STEP_OF_GIF = 4; // hundredths of a second; browsers show shorter ones slower
const MOST_PICTURES = 600; // in a GIF
const VIDEO = globalThis.MediaRecorder && HTMLCanvasElement.prototype.captureStream
  && ["video/mp4;codecs=avc1.42E01F", "video/webm;codecs=vp9", "video/webm"].find((type) =>
    MediaRecorder.isTypeSupported(type));
const ENDING = VIDEO?.startsWith("video/mp4") ? "mp4" : "webm";

/** A canvas for pictures of a stage, whose sides are multiples of so many pixels; `paint` fills it. */
class Film {
  constructor(stage, density, paper, multiple = 1) {
    const { clientWidth, clientHeight } = stage.canvas;
    const pixels = (side) => multiple * Math.max(1, Math.round((side * density) / multiple));
    const [width, height] = [pixels(clientWidth), pixels(clientHeight)];
    this.canvas = Object.assign(document.createElement("canvas"), { width, height });
    this.context = this.canvas.getContext("2d", { willReadFrequently: density <= 1 });
    Object.assign(this, { stage, paper, scales: [width / clientWidth, height / clientHeight] });
  }

  paint(moment) {
    const { context, canvas, scales: [x, y] } = this;
    context.setTransform(x, 0, 0, y, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.fillStyle = colours.paper;
    if (this.paper) context.fillRect(0, 0, canvas.width, canvas.height);
    this.stage.paint(context, moment);
  }

  get pixels() {
    return this.context.getImageData(0, 0, this.canvas.width, this.canvas.height).data;
  }
}

function picture(stage, moment, paper) {
  const film = new Film(stage, Math.max(SHARP, devicePixelRatio), paper);
  film.paint(moment);
  return new Promise((done) => film.canvas.toBlob(done, "image/png"));
}

/**
 * A video of a part of the time: `{ from, duration, moment }`, the moment at so many seconds. It takes as long as it
 * lasts, as browsers record a canvas; `task` has `progress(share)`, and `cancelled`, then there is no video.
 */
async function video(stage, { duration, moment }, task) {
  const { clientWidth, clientHeight } = stage.canvas;
  const most = LONG_SIDE_OF_VIDEO / Math.max(clientWidth, clientHeight);
  const film = new Film(stage, Math.min(devicePixelRatio, most), true, 2); // as encoders need
  film.paint(moment(0));
  const recorder = new MediaRecorder(film.canvas.captureStream(), { mimeType: VIDEO, videoBitsPerSecond: 8e6 });
  const parts = [];
  recorder.addEventListener("dataavailable", ({ data: part }) => parts.push(part));
  const ended = new Promise((done) => recorder.addEventListener("stop", done));
  recorder.start();
  let [seconds, before] = [0, null];
  const whole = duration * Math.ceil(1 / duration); // at least a second, as encoders take some frames to begin
  while (seconds < whole && !task.cancelled) {
    const now = await new Promise(requestAnimationFrame);
    seconds += before === null ? 0 : Math.min((now - before) / 1000, LONGEST);
    before = now;
    film.paint(moment(seconds < whole ? seconds % duration : duration));
    task.progress(seconds / whole);
  }
  recorder.stop();
  await ended;
  if (task.cancelled) return null;
  return new Blob(parts, { type: `video/${ENDING}` });
}

async function movingPicture(stage, { duration, moment }, task) {
  const { clientWidth, clientHeight } = stage.canvas;
  const film = new Film(stage, Math.min(1, LONG_SIDE / Math.max(clientWidth, clientHeight)), true);
  const step = Math.max(STEP_OF_GIF, Math.ceil((100 * duration) / MOST_PICTURES));
  const count = Math.max(1, Math.round((100 * duration) / step));
  const pixelsAt = (i) => (film.paint(moment((i * step) / 100)), film.pixels);
  const some = new Set(Array.from({ length: 6 }, (_, i) => Math.floor((i * count) / 6)));
  const gif = new Gif(film.canvas.width, film.canvas.height, paletteOf([...some].map(pixelsAt)));
  for (let i = 0; i < count && !task.cancelled; i++) {
    gif.add(pixelsAt(i), step);
    task.progress((i + 1) / count);
    await new Promise((done) => setTimeout(done)); // so that the page stays alive
  }
  return task.cancelled ? null : gif.file;
}

function download(blob, name) {
  const address = URL.createObjectURL(blob);
  Object.assign(document.createElement("a"), { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

const fileName = (title) =>
  title.replace(/[^\p{L}\p{N}.-]+/gu, "_").slice(0, 80).replace(/^[._]+|[._]+$/g, "") || "motion";

/**
 * Let the buttons of the dialog make files of a stage; `now()` is the moment that is shown, `loop()` the part of the
 * time, and `begin()` is called before a file is made that takes time.
 */
function listenForFiles(stage, { now, loop, begin }) {
  let task = null;
  const name = fileName(data.title);
  const make = async (work, ending) => {
    if (task) return;
    begin();
    const own = task = { cancelled: false, progress: (share) => (element("progress").value = share) };
    element("work").hidden = false;
    element("said").textContent = "";
    try {
      const file = await work(stage, loop(), own);
      if (file) download(file, `${name}.${ending}`);
      element("said").textContent = file ? `${name}.${ending}, ${(file.size / 1e6).toPrecision(2)} MB` : "Cancelled.";
    } catch (error) {
      element("said").textContent = `No file: ${error.message}`;
    }
    element("work").hidden = true;
    task = null;
  };
  const cancel = () => task && (task.cancelled = true);
  element("picture").addEventListener("click", async () => {
    download(await picture(stage, now(), element("paper").checked), `${name}.png`);
    element("said").textContent = `${name}.png`;
  });
  element("video").hidden = !VIDEO;
  element("video").addEventListener("click", () => make(video, ENDING));
  element("gif").addEventListener("click", () => make(movingPicture, "gif"));
  element("cancel").addEventListener("click", cancel);
  element("sharing").addEventListener("close", cancel);
  addEventListener("resize", cancel); // pictures of two sizes are no film
}
