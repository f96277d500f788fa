// Which joint of a skeleton is its left knee, by the names of rigs: `find_landmarks` of
// skpose/kinematics/_landmarks.py, and `split_sides` of skpose/skeleton/_sides.py. Names, patterns and numbers are
// theirs.

const { landmarks: FINDER, sides: SIDE_NAMES } = data.constants;
const { SIDES, ANKLE, BALL, ELBOW, HAND, HEAD, HIP, KNEE, SHOULDER, TOE, WRIST } = FINDER;
const regexOf = ([source, flags]) => new RegExp(source, `${flags}g`);
const SIGNS = regexOf(FINDER.SIGNS);
const NUMBERED = new RegExp(`^${FINDER.NUMBERED[0]}$`, FINDER.NUMBERED[1]); // all of a name
const [SURE, MAYBE] = [SIDE_NAMES.SURE, SIDE_NAMES.MAYBE].map((patterns) => patterns.map(regexOf));

const isUpper = (word) => word === word.toUpperCase();

function otherSide(word) {
  const found = SIDE_NAMES.OTHER[word.toLowerCase()];
  if (isUpper(word)) return found.toUpperCase();
  return isUpper(word[0]) ? found[0].toUpperCase() + found.slice(1) : found;
}

/** The side of each name, and the name without the word or letter for it. */
function splitSides(names) {
  const known = new Set(names);
  return names.map((name) => {
    const isThere = (pattern) => known.has(name.replace(pattern, otherSide));
    const pattern = SURE.find((one) => name.search(one) >= 0)
      ?? MAYBE.find((one) => name.search(one) >= 0 && isThere(one));
    if (!pattern) return { side: "", rest: name };
    const [at, [word]] = [name.search(pattern), name.match(pattern)];
    const side = SIDES.find((one) => one[0] === word[0].toLowerCase());
    return { side, rest: name.slice(0, at) + name.slice(at + word.length) };
  });
}

/** Names without a number that all of them end with. */
function withoutNumber(names) {
  const found = names.map((name) => NUMBERED.exec(name));
  if (found.length < 2 || !found[0] || found.some((match) => match?.[2] !== found[0][2])) return names;
  return found.map(([, start, , end]) => start + end);
}

function commonStart([first, ...names]) {
  let start = "";
  if (!names.length) return start;
  for (const letter of first) { // which may be two numbers of JavaScript's
    if (!names.every((name) => name.startsWith(start + letter))) break;
    start += letter;
  }
  return start;
}

/** The side of each name, and the rest of it in lower case without signs between words. */
function keysOf(given) {
  const names = withoutNumber(given.map((name) => name.slice(name.lastIndexOf(":") + 1) || name));
  const { length } = commonStart(names);
  return splitSides(names.map((name) => name.slice(length)))
    .map(({ side, rest }) => ({ side, rest: rest.replace(SIGNS, "").toLowerCase() }));
}

function pathUp(parents, joint) {
  const path = [];
  for (let j = joint; j >= 0; j = parents[j]) path.push(j);
  return path;
}

const isAfter = (parents, joint, above) => pathUp(parents, parents[joint]).includes(above);

function between(parents, above, below) {
  const path = pathUp(parents, below);
  return path.slice(0, Math.max(0, path.indexOf(above)));
}

/** The last joint that both joints come after; −1 is the root. */
function commonParent(parents, a, b) {
  const above = pathUp(parents, parents[a]);
  return pathUp(parents, parents[b]).find((joint) => above.includes(joint)) ?? -1;
}

function positionsAtZero({ parents, offsets }) {
  const where = [];
  parents.forEach((parent, j) => where.push(offsets[j].map((value, axis) => value + (where[parent]?.[axis] ?? 0))));
  return where;
}

const lengthOfBones = ({ offsets }, joints) => joints.reduce((sum, j) => sum + Math.hypot(...offsets[j]), 0);

/** The joints of a rig by landmark, and how many of its names there are; none without both legs or both arms. */
function findRig({ left, middle }, keys, ends) {
  const last = new Set(ends.values());
  const joints = {};
  let known = 0;
  for (const [j, { side, rest }] of keys.entries()) {
    const table = side ? left : middle;
    if (!Object.hasOwn(table, rest) || last.has(j)) continue;
    known++;
    if (!table[rest]) continue;
    const mark = side ? `${side}_${table[rest]}` : table[rest];
    if (mark in joints) return { joints: {}, known: 0 };
    joints[mark] = j;
  }
  const hasAll = (limb) => SIDES.every((side) => limb.every((mark) => `${side}_${mark}` in joints));
  const [legs, arms] = FINDER.LIMBS.map(hasAll);
  if (!legs && !arms) return { joints: {}, known: 0 };
  const [ofLeg, ofArm] = FINDER.ORDER;
  const out = [...(legs ? [] : [...ofLeg, BALL, TOE]), ...(arms ? [] : [...ofArm, HAND])];
  for (const side of SIDES) for (const mark of out) delete joints[`${side}_${mark}`];
  return { joints, known };
}

/** By joint the child that has its name and a word for the end. */
function endsOf(keys, parents) {
  const ends = new Map();
  keys.forEach(({ side, rest }, j) => {
    const before = keys[parents[j]];
    if (before && side === before.side && FINDER.END_NAMES.some((word) => rest === before.rest + word)) {
      ends.set(parents[j], j);
    }
  });
  return ends;
}

/** Add the ends of hands, head and feet, where no other joint is known to be there. */
function addEnds(joints, ends, skeleton) {
  for (const prefix of ["", ...SIDES.map((side) => `${side}_`)]) {
    for (const [mark, end] of Object.entries(FINDER.ENDS)) {
      const joint = ends.get(joints[prefix + mark]);
      if (joint !== undefined) joints[prefix + end] ??= joint;
    }
  }
  for (const side of SIDES) {
    const toe = ends.get(joints[`${side}_${ANKLE}`]);
    const isKnown = `${side}_${BALL}` in joints || `${side}_${TOE}` in joints;
    if (toe !== undefined && !isKnown && pointsForward(skeleton, toe, joints)) joints[`${side}_${TOE}`] = toe;
  }
}

const dot = (a, b) => a.reduce((sum, value, axis) => sum + value * b[axis], 0);
const minus = (a, b) => a.map((value, axis) => value - b[axis]);
const middleOf = (a, b) => a.map((value, axis) => (value + b[axis]) / 2);

/** Whether the bone that ends at a joint points forward at angle zero, by hips and shoulders. */
function pointsForward(skeleton, joint, joints) {
  const needed = [HIP, SHOULDER].flatMap((mark) => SIDES.map((side) => `${side}_${mark}`));
  if (!needed.every((mark) => mark in joints)) return false;
  const where = positionsAtZero(skeleton);
  const [left, right, ...shoulders] = needed.map((mark) => where[joints[mark]]);
  const [a, b] = [minus(left, right), minus(middleOf(...shoulders), middleOf(left, right))];
  const forward = [0, 1, 2].map((i) => a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3]);
  const bone = minus(where[joint], where[skeleton.parents[joint]]);
  return dot(bone, forward) > FINDER.FORWARD * Math.hypot(...bone) * Math.hypot(...forward);
}

/** Whether joints do not follow each other as in a person. */
function isMisplaced({ parents }, joints) {
  const isWrong = SIDES.some((side) => FINDER.ORDER.some((order) => {
    const here = order.map((mark) => joints[`${side}_${mark}`]).filter((joint) => joint !== undefined);
    return here.slice(1).some((joint, i) => !isAfter(parents, joint, here[i]));
  }));
  const before = pathUp(parents, joints[HEAD]);
  return isWrong || SIDES.some((side) => [SHOULDER, HIP].some((mark) => before.includes(joints[`${side}_${mark}`])));
}

function isDisproportionate(skeleton, joints) {
  const sides = SIDES.map((side) => {
    const lengths = {};
    for (const [part, [start, end]] of Object.entries(FINDER.LENGTHS)) {
      const bones = between(skeleton.parents, joints[`${side}_${start}`], joints[`${side}_${end}`]);
      if (bones.length) lengths[part] = lengthOfBones(skeleton, bones);
    }
    return lengths;
  });
  return sides.some((lengths) => FINDER.PROPORTIONS.some(([first, second, low, high]) => {
    const [a, b] = [lengths[first], lengths[second]];
    return a !== undefined && b !== undefined && !(low * b <= a && a <= high * b);
  })) || ["leg", "arm"].some((whole) => {
    const lengths = sides.map((one) => one[whole] ?? 0);
    return Math.max(...lengths) > FINDER.SYMMETRY * Math.min(...lengths);
  });
}

/** The joints after the hips up to the one that carries the arms. */
function trunkOf(parents, joints) {
  const [hips, shoulders] = [HIP, SHOULDER].map((mark) => SIDES.map((side) => joints[`${side}_${mark}`])
    .filter((joint) => joint !== undefined));
  if (shoulders.length < 2) return [];
  const below = hips.length === 2 ? pathUp(parents, commonParent(parents, ...hips)) : [];
  return pathUp(parents, commonParent(parents, ...shoulders)).reverse().filter((joint) => !below.includes(joint));
}

/** The joints of a person by landmark, and those of the trunk; null if it is none, or uncertain. */
function findLandmarks(skeleton) {
  const { names, parents } = skeleton;
  const keys = keysOf(names);
  const ends = endsOf(keys, parents);
  const candidates = FINDER.rigs.map((rig) => findRig(rig, keys, ends));
  const most = Math.max(...candidates.map(({ known }) => known));
  if (!most || keys.some(({ rest }) => FINDER.NO_PERSON.some((word) => rest.startsWith(word)))) return null;
  const found = candidates.filter(({ known }) => known === most).map(({ joints }) => joints);
  if (found.some((joints) => isMisplaced(skeleton, joints) || isDisproportionate(skeleton, joints))) return null;
  // Several rigs may have the same names: what they agree on is certain.
  const joints = Object.fromEntries(Object.entries(found[0]).filter(([mark, joint]) =>
    found.every((other) => other[mark] === joint)));
  addEnds(joints, ends, skeleton);
  return { joints, trunk: trunkOf(parents, joints) };
}
