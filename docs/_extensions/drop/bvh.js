// BVH files: joints and frames, by the rules of `skpose.io.load_bvh`. Angles become rad, lengths stay as they are.

const CHANNELS = /^[xyz](position|rotation)$/;

// Blanks of the format are those of ASCII.
const WORD = /[{}]|[^ \t\r\n\v\f{}]+/g;
const AFTER_MOTION = /^\s*Frames:\s*(?<count>\d+)\s+Frame\s+Time:\s*(?<seconds>\S+)/i;
const NAME = /[^{}\r\n]*/y;
const WORD_OF_ROW = /[^ \t\r\n\v\f]+/g;
const NUMBER = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;

const numberOf = (word) => (NUMBER.test(word) ? Number(word) : NaN);

class FileError extends Error {}

class Lexer {
  constructor(text) {
    Object.assign(this, { text, at: 0 });
  }

  next(pattern = WORD) {
    pattern.lastIndex = this.at;
    const word = pattern.exec(this.text)?.[0];
    this.at = word === undefined ? this.text.length : pattern.lastIndex;
    return word ?? "";
  }

  /** The rest of the line, up to a brace: names may have blanks in them. */
  name() {
    return this.next(NAME).trim();
  }
}

/** Read a file's text: joints in its order, the root first, frames as rows of numbers, and the frame rate, Hz. */
function readBvh(text) {
  const lexer = new Lexer(text);
  if (lexer.next().toUpperCase() !== "HIERARCHY") throw new FileError("it does not begin with HIERARCHY");
  const joints = readJoints(lexer);
  const width = joints.reduce((sum, joint) => sum + joint.channels.length, 0);
  const head = AFTER_MOTION.exec(text.slice(lexer.at));
  const [count, seconds] = [Number(head?.groups.count), numberOf(head?.groups.seconds)];
  if (!(count > 0 && width > 0 && seconds > 0)) throw new FileError("it has no Frames:, Frame Time: or CHANNELS");
  const numbers = Float64Array.from(text.slice(lexer.at + head[0].length).match(WORD_OF_ROW) ?? [], numberOf);
  if (numbers.length !== count * width || numbers.some((number) => !Number.isFinite(number))) {
    throw new FileError(`it must have ${count} frames of ${width} numbers, and has ${numbers.length}: is it cut short?`);
  }
  return { joints, width, numbers, count, rate: 1 / seconds };
}

function readJoints(lexer) {
  const joints = [];
  let [open, first, word] = [-1, 0, ""];
  while ((word = lexer.next())) {
    const keyword = word.toUpperCase();
    const joint = joints[open];
    if (keyword === "ROOT" ? !joints.length : joint && ["JOINT", "END"].includes(keyword)) {
      const name = lexer.name(); // that of an End Site is not used
      joints.push({ name: keyword === "END" ? "" : name, parent: open, offset: null, channels: [], first });
      open = joints.length - 1;
      if (lexer.next() !== "{") throw new FileError(`after ${keyword} a name and a brace are expected`);
    } else if (joint && keyword === "OFFSET") {
      joint.offset = [0, 1, 2].map(() => numberOf(lexer.next()));
      if (!joint.offset.every(Number.isFinite)) throw new FileError(`the OFFSET of ${joint.name} is not three numbers`);
    } else if (joint && keyword === "CHANNELS") {
      const count = Number(lexer.next());
      joint.channels = Array.from({ length: Math.min(count, 6) }, () => lexer.next().toLowerCase());
      Object.assign(joint, { first });
      first += joint.channels.length;
      if (!joint.channels.every((channel) => CHANNELS.test(channel)) || new Set(joint.channels).size !== count) {
        throw new FileError(`the CHANNELS of ${joint.name} are not different positions and rotations`);
      }
    } else if (joint?.offset && word === "}") {
      open = joint.parent;
    } else if (open < 0 && joints.length && keyword === "MOTION") {
      nameJoints(joints);
      return joints;
    } else throw new FileError(`“${word}” is not expected in HIERARCHY`);
  }
  throw new FileError("it ends within HIERARCHY: is it cut short?");
}

/** Give each joint but the root another name: the first of a name keeps it; an End Site is named by its parent. */
function nameJoints([root, ...joints]) {
  for (const joint of joints) joint.end = !joint.name;
  const [taken, counts] = [new Map(), new Map()];
  for (const joint of joints) if (joint.name && !taken.has(joint.name)) taken.set(joint.name, joint);
  for (const joint of joints) {
    if (taken.get(joint.name) === joint) continue;
    const stem = joint.name || `${[root, ...joints][joint.parent].name}_end`;
    let name = stem;
    while (taken.has(name)) {
      counts.set(stem, (counts.get(stem) ?? 1) + 1);
      name = `${stem}_${counts.get(stem)}`;
    }
    taken.set(name, joint);
    joint.name = name;
  }
}

/** Columns of a joint's channels of a kind, as [axis, column], in the file's order. */
const columnsOf = (joint, kind) => joint.channels
  .map((channel, i) => ["xyz".indexOf(channel[0]), joint.first + i, channel.endsWith(kind)])
  .filter(([, , is]) => is);

function rangeOf({ numbers, width, count }, column) {
  let [low, high, sum] = [Infinity, -Infinity, 0];
  for (let frame = 0; frame < count; frame++) {
    const number = numbers[frame * width + column];
    [low, high, sum] = [Math.min(low, number), Math.max(high, number), sum + number];
  }
  return { extent: high - low, far: Math.max(Math.abs(low), Math.abs(high)), mean: sum / count };
}

// As shares of the longest bone: by how much a constant position varies by its digits, and what is zero but for noise.
const [ROUNDING, UNUSED] = [1e-4, 1e-3];
const SAME_PLACE = 1e-9; // m, between joints in one place
const TURNS = (180 * ROUNDING) / Math.PI; // degrees by which an angle that stands still varies

function longestOf(file, joints) {
  return Math.max(0, ...joints.flatMap((joint) => {
    const moved = [...joint.offset];
    for (const [axis, column] of columnsOf(joint, "position")) moved[axis] = rangeOf(file, column).mean;
    return [Math.hypot(...joint.offset), Math.hypot(...moved)];
  }));
}

/** Whether the positions of a joint leave zero. */
const travelsFar = (file, joint, longest) =>
  columnsOf(joint, "position").some(([, column]) => rangeOf(file, column).far > UNUSED * longest);

/** The joint that is the root: the first one, or the only child that travels, if all above it stands still. */
function rootOf(file) {
  const { joints } = file;
  const longest = longestOf(file, joints.slice(1));
  const varies = (joint, kind, least) => columnsOf(joint, kind).some(([, column]) => rangeOf(file, column).extent > least);
  const moves = (joint) => varies(joint, "position", ROUNDING * longest);
  for (let j = 0; j < joints.length - 1; j++) {
    const children = joints.filter(({ parent }) => parent === j);
    if (children.length !== 1 || children[0].end || moves(joints[j]) || varies(joints[j], "rotation", TURNS)) return 0;
    if (moves(children[0]) && travelsFar(file, children[0], longest)) return j + 1;
  }
  return 0;
}

/**
 * The motion of a file, in units of its lengths times a scale: `skeleton` as `skeleton_data` of
 * skpose/view/_explorer.py has it, poses (Float64Array each), positions and orientations of the root, and the rate.
 */
function motionOf(file, scale) {
  const { joints, numbers, width, count } = file;
  const root = rootOf(file);
  const chain = [];
  for (let j = root; j >= 0; j = joints[j].parent) chain.unshift(j);
  const below = joints.map((_, j) => j).filter((j) => {
    for (let k = joints[j].parent; k >= 0; k = joints[k].parent) if (k === root) return true;
    return false;
  });
  if (!below.some((j) => columnsOf(joints[j], "rotation").length)) {
    throw new FileError(`no joint below the root ${joints[root].name} has rotation channels, so that there is no pose: `
      + "export it with the joints of its skeleton");
  }
  const longest = longestOf(file, below.map((j) => joints[j]));
  const travels = new Set(chain.filter((j) => j === 0 || travelsFar(file, joints[j], longest)));
  const offsets = below.map((j) => offsetOf(file, joints[j], longest));
  const skeleton = {
    names: below.map((j) => joints[j].name),
    parents: below.map((j) => below.indexOf(joints[j].parent)),
    offsets: offsets.map((offset) => offset.map((value) => scale * value)),
    dofs: below.map((j) => columnsOf(joints[j], "rotation").map(([axis]) => "XYZ"[axis]).join("")),
    axes: below.map(() => null),
    rests: below.map(() => null),
    sides: splitSides(below.map((j) => joints[j].name)).map(({ side }) => side),
    offsetFrame: "parent",
  };
  skeleton.weights = weightsOf(skeleton);
  const columns = below.flatMap((j) => columnsOf(joints[j], "rotation").map(([, column]) => column));
  skeleton.columns = below.flatMap((j) =>
    columnsOf(joints[j], "rotation").map(([axis]) => `${joints[j].name}_r${"xyz"[axis]}`));
  const [poses, positions, orientations] = [[], [], []];
  for (let frame = 0; frame < count; frame++) {
    const row = numbers.subarray(frame * width, (frame + 1) * width);
    poses.push(Float64Array.from(columns, (column) => (row[column] * Math.PI) / 180));
    let [at, q] = [[0, 0, 0], [1, 0, 0, 0]];
    for (const j of chain) {
      const offset = [...joints[j].offset];
      if (travels.has(j)) for (const [axis, column] of columnsOf(joints[j], "position")) offset[axis] = row[column];
      at = rotations.apply(q, offset).map((value, axis) => value + at[axis]);
      for (const [axis, column] of columnsOf(joints[j], "rotation")) {
        q = rotations.product(q, rotations.about(axis, (row[column] * Math.PI) / 180));
      }
    }
    positions.push(at.map((value) => scale * value));
    orientations.push(q);
  }
  return { skeleton, poses, positions, orientations, rate: file.rate };
}

/** A bone's offset: OFFSET, or what its position channels have, where these are used and constant. */
function offsetOf(file, joint, longest) {
  const offset = [...joint.offset];
  if (!travelsFar(file, joint, longest)) return offset;
  for (const [axis, column] of columnsOf(joint, "position")) {
    const { extent, mean } = rangeOf(file, column);
    if (extent > ROUNDING * longest) throw new FileError(`${joint.name} moves by position channels, its bone must not`);
    offset[axis] = mean;
  }
  return offset;
}

/** Weights of the joints: 1, or 0 where another one is in the same place in every pose. */
function weightsOf(skeleton) {
  const kinematics = new Skeleton({ ...skeleton, weights: [] });
  const some = [1, 2, 3].map((k) =>
    kinematics.positions(Float64Array.from({ length: kinematics.width }, (_, i) => Math.sin(k + 12.9898 * i * k))));
  const isSame = (j, k) => some.every((at) =>
    [0, 1, 2].every((i) => Math.abs(at[3 * j + i] - at[3 * k + i]) <= SAME_PLACE));
  return skeleton.names.map((_, j) => Number(!skeleton.names.some((_, k) => k < j && isSame(j, k))));
}
