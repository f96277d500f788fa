// Moving pictures as GIF (version 89a): a palette by median cut, and compression by LZW.

const SHADES = 255; // in the palette; the last index is "as before"
const BEFORE = 255;
const bin = (pixels, at) => ((pixels[at] >> 3) << 10) | ((pixels[at + 1] >> 3) << 5) | (pixels[at + 2] >> 3);

/** The colours that stand for all in some pictures, red, green, blue one after another. */
function paletteOf(pictures) {
  const bins = new Map();
  for (const pixels of pictures) {
    for (let at = 0; at < pixels.length; at += 4) {
      const key = bin(pixels, at);
      const one = bins.get(key) ?? bins.set(key, [0, 0, 0, 0]).get(key); // sums, and how many
      for (let c = 0; c < 3; c++) one[c] += pixels[at + c];
      one[3]++;
    }
  }
  const boxOf = (colours) => {
    const ranges = [0, 1, 2].map((c) => {
      const values = colours.map((one) => one.mean[c]);
      return Math.max(...values) - Math.min(...values);
    });
    const count = colours.reduce((sum, one) => sum + one.count, 0);
    const widest = Math.max(...ranges);
    return { colours, count, channel: ranges.indexOf(widest), size: colours.length > 1 ? widest * count ** 0.3 : 0 };
  };
  const all = [...bins.values()].map(([r, g, b, count]) => ({ mean: [r / count, g / count, b / count], count }));
  const boxes = [boxOf(all)];
  while (boxes.length < SHADES) {
    const largest = boxes.reduce((best, box, i) => (box.size > boxes[best].size ? i : best), 0);
    const { colours, channel, count, size } = boxes[largest];
    if (!size) break;
    colours.sort((a, b) => a.mean[channel] - b.mean[channel]);
    let [half, below] = [0, 0];
    while (half < colours.length - 1 && (half === 0 || below < count / 2)) below += colours[half++].count;
    boxes.splice(largest, 1, boxOf(colours.slice(0, half)), boxOf(colours.slice(half)));
  }
  const palette = new Uint8Array(3 * (SHADES + 1));
  boxes.forEach(({ colours, count }, i) => {
    for (let c = 0; c < 3; c++) {
      palette[3 * i + c] = Math.round(colours.reduce((sum, one) => sum + one.count * one.mean[c], 0) / count);
    }
  });
  return palette.subarray(0, 3 * boxes.length);
}

class Gif {
  parts = [];
  nearest = new Int16Array(32768).fill(-1); // index in the palette by bin
  before = null; // indices of the picture before

  constructor(width, height, palette) {
    Object.assign(this, { width, height, palette });
    const full = new Uint8Array(3 * (SHADES + 1));
    full.set(palette);
    this.write("GIF89a", word(width), word(height), [0xf7, 0, 0], full);
    this.write([0x21, 0xff, 11], "NETSCAPE2.0", [3, 1, 0, 0, 0]); // for ever
  }

  write(...parts) {
    for (const part of parts) {
      this.parts.push(typeof part === "string" ? new TextEncoder().encode(part) : Uint8Array.from(part));
    }
  }

  indexOf(pixels, at) {
    const key = bin(pixels, at);
    if (this.nearest[key] >= 0) return this.nearest[key];
    let least = Infinity;
    for (let i = 0; i < this.palette.length / 3; i++) {
      let far = 0;
      for (let c = 0; c < 3; c++) far += (this.palette[3 * i + c] - pixels[at + c]) ** 2;
      if (far < least) [least, this.nearest[key]] = [far, i];
    }
    return this.nearest[key];
  }

  /** Add a picture, pixels as a canvas has them, which is shown for so many hundredths of a second. */
  add(pixels, delay) {
    const indices = new Uint8Array(this.width * this.height);
    for (let i = 0; i < indices.length; i++) indices[i] = this.indexOf(pixels, 4 * i);
    const changes = this.before ? indices.map((index, i) => (index === this.before[i] ? BEFORE : index)) : indices;
    this.before = indices;
    this.write([0x21, 0xf9, 4, 5], word(delay), [BEFORE, 0]); // a picture stays below the next one
    this.write([0x2c, 0, 0, 0, 0], word(this.width), word(this.height), [0, 8]);
    const codes = compress(changes);
    for (let at = 0; at < codes.length; at += 255) {
      const block = codes.subarray(at, at + 255);
      this.write([block.length], block);
    }
    this.write([0]);
  }

  get file() {
    return new Blob([...this.parts, Uint8Array.of(0x3b)], { type: "image/gif" });
  }
}

const word = (value) => [value & 255, value >> 8];

/** Bytes as codes of LZW that grow from 9 to 12 bits. */
function compress(bytes) {
  const [clear, end] = [256, 257];
  const table = new Int16Array(4096 * 256); // the code of a code and the byte after it
  const out = new Uint8Array(2 * bytes.length + 16);
  let [size, next, held, bits, length] = [9, 258, 0, 0, 0];
  const emit = (code) => {
    held |= code << bits;
    for (bits += size; bits >= 8; bits -= 8) {
      out[length++] = held & 255;
      held >>>= 8;
    }
  };
  emit(clear);
  let code = bytes[0];
  for (let i = 1; i < bytes.length; i++) {
    const key = (code << 8) | bytes[i];
    if (table[key]) {
      code = table[key];
      continue;
    }
    emit(code);
    if (next < 4096) {
      if (next === 1 << size) size++;
      table[key] = next++;
    } else {
      emit(clear);
      table.fill(0);
      [size, next] = [9, 258];
    }
    code = bytes[i];
  }
  emit(code);
  if (next === 1 << size && size < 12) size++; // as the reader's table has grown
  emit(end);
  out[length++] = held & 255;
  return out.subarray(0, length);
}
