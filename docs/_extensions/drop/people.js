// Where a person is in a skeleton: `find_anatomy` of skpose/kinematics/_anatomy.py, for BVH files, and `split_sides` of
// skpose/skeleton/_sides.py. Names, patterns and numbers are theirs.

const { anatomy: FINDER, sides: SIDE_NAMES } = data.constants;
const { SIDES, ANKLE, BALL, COLLAR, ELBOW, HAND, HEAD, HIP, KNEE, SHOULDER, TOE, WRIST } = FINDER;
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
    const side = SIDES[Number(!"lL左".includes(word[0]))];
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
const searched = (words, name) => new RegExp(words, "u").test(name);

/** A skeleton as a tree of lengths and words: `_Tree`. */
function treeOf({ names, parents, offsets }) {
  const keys = keysOf(names);
  const parts = keys.map(({ rest }) => Object.keys(FINDER.PARTS).find((part) => searched(FINDER.PARTS[part], rest)) ?? "");
  const partners = keys.map(({ side, rest }) =>
    side ? keys.findIndex((key) => key.rest === rest && key.side && key.side !== side) : -1);
  const lengths = offsets.map((offset) => Math.hypot(...offset));
  const children = Object.fromEntries([-1, ...parents.keys()].map((j) => [j, []]));
  const reach = { [-1]: 0, ...parents.map(() => 0) };
  for (let j = parents.length - 1; j >= 0; j--) {
    children[parents[j]].unshift(j);
    reach[parents[j]] = Math.max(reach[parents[j]], lengths[j] + reach[j]);
  }
  const span = (j) => lengths[j] + reach[j];
  const longest = (joints) => joints.reduce((best, j) => (span(j) > span(best) ? j : best));
  const isNear = (length) => length <= FINDER.SMALL * reach[-1];
  const after = (joint, without) => children[joint]
    .flatMap((j) => (isNear(lengths[j]) ? after(j, without) : [j]))
    .filter((j) => !searched(without, keys[j].rest));
  const chain = (joint) => {
    const below = children[joint].filter((j) => partners[j] >= 0);
    return [joint, ...(below.length ? chain(longest(below)) : [])];
  };
  return { keys, parts, partners, lengths, reach, longest, isNear, after, chain };
}

/** Whether a list of numbers comes after another in their order. */
function isAbove(a, b) {
  const i = a.findIndex((value, at) => value !== b[at]);
  return i >= 0 && a[i] > b[i];
}

/** The joints of both legs and both arms, as far as they are found. */
function findLimbs(tree, parents) {
  const starts = [];
  for (const [left, { side }] of tree.keys.entries()) {
    if (side !== SIDES[0] || tree.partners[left] < 0 || tree.keys[parents[left]]?.side) continue;
    const parts = tree.chain(left).map((j) => tree.parts[j]).filter((part) => part && part !== "twist");
    const votes = parts.reduce((sum, part) => sum + (FINDER.OF_LEG.includes(part) ? 1 : -1), 0);
    starts.push({ votes, depth: pathUp(parents, parents[left]).reduce((sum, j) => sum + tree.lengths[j], 0), left });
  }
  const joints = {};
  let above = -1; // the distance from the root at which the legs begin
  for (const [limb, sign] of [[0, 1], [1, -1]]) {
    let best = { order: [-1], chain: [], depth: above };
    for (const { votes, depth, left } of starts) {
      const { chain, isUsual } = splitLimb(tree, tree.chain(left), limb);
      if (!chain.length || sign * votes < 0 || Object.values(joints).includes(chain[0])) continue;
      const order = [Number(votes !== 0), Number(isUsual), Number(depth > above), votes ? 0 : -depth, tree.reach[left]];
      if (isAbove(order, best.order)) best = { order, chain, depth };
    }
    above = best.depth;
    for (const [i, joint] of best.chain.entries()) {
      const mark = [...FINDER.LIMBS[limb], COLLAR][i];
      Object.assign(joints, { [`left_${mark}`]: joint, [`right_${mark}`]: tree.partners[joint] });
    }
  }
  return joints;
}

/** The three joints of a limb in a chain, after them the collarbone's, and whether lengths are usual. */
function splitLimb(tree, chain, limb) {
  const places = []; // joints at one place, and the parts in their names, each where it is first
  let along = 0;
  for (const [i, joint] of chain.entries()) {
    along += i && tree.lengths[joint];
    if (!i || !tree.isNear(along - places.at(-1).at)) places.push({ at: along, joints: [], parts: [] });
    const isFirst = places.every(({ parts }) => !parts.includes(tree.parts[joint]));
    places.at(-1).joints.push(joint);
    places.at(-1).parts.push(isFirst ? tree.parts[joint] : "");
  }
  const n = Math.min(places.length, FINDER.LONGEST);
  let best = { order: null, chain: [], isUsual: false };
  for (let a = 0; a < n; a++) for (let b = a + 1; b < n; b++) for (let c = b + 1; c < n; c++) {
    const three = [places[a], places[b], places[c]];
    const [start, middle, end] = three.map(({ at }) => at);
    const [ratio, whole, last] = [(middle - start) / (end - middle), end - start, places.at(-1).at];
    for (const [names, vague, more] of FINDER.CONVENTIONS) {
      const agree = three.reduce((sum, { parts }, i) => sum + (parts.some((part) => names[limb][i].includes(part))
        ? 1 + more * parts.includes(FINDER.LIMBS[limb][i])
        : -Number(!parts.some((part) => vague.includes(part)))), 0);
      const [low, high] = (agree >= FINDER.SURE ? FINDER.NAMED : FINDER.RATIOS)[limb];
      const isUsual = low <= ratio && ratio <= high;
      const isMost = Math.max(start / FINDER.BEFORE[limb], (last - end) / FINDER.AFTER[limb]) <= whole
        && whole >= FINDER.MOST[limb] * last;
      const order = [Number(isUsual), agree, -Math.abs(Math.log(ratio / FINDER.TYPICAL[limb]))];
      if (!(agree >= FINDER.SURE || (isUsual && isMost)) || (best.order && !isAbove(order, best.order))) continue;
      const joints = three.map((place, i) =>
        place.joints.find((j) => names[limb][i].includes(tree.parts[j])) ?? place.joints[0]);
      best = { order, isUsual, chain: [...joints, ...(limb && a ? places[a - 1].joints.slice(-1) : [])] };
    }
  }
  return best;
}

const dot = (a, b) => a.reduce((sum, value, axis) => sum + value * b[axis], 0);
const minus = (a, b) => a.map((value, axis) => value - b[axis]);
const middleOf = (a, b) => a.map((value, axis) => (value + b[axis]) / 2);

/** Add the joints of feet, hands and the head. */
function addEnds(tree, joints, skeleton) {
  for (const side of SIDES) {
    const ahead = (mark, without) => (`${side}_${mark}` in joints ? tree.after(joints[`${side}_${mark}`], without) : []);
    const feet = ahead(ANKLE, FINDER.HEEL);
    const first = feet.length ? tree.longest(feet) : -1;
    const second = first < 0 ? [] : tree.after(first, FINDER.HEEL);
    if (second.length) Object.assign(joints, { [`${side}_${BALL}`]: first, [`${side}_${TOE}`]: tree.longest(second) });
    else if (first >= 0 && skeleton.dofs[first]) joints[`${side}_${BALL}`] = first;
    else if (first >= 0 && pointsForward(skeleton, first, joints)) joints[`${side}_${TOE}`] = first;
    const hands = ahead(WRIST, "thumb");
    const words = FINDER.FINGERS.find((one) => hands.some((j) => searched(one, tree.keys[j].rest)));
    if (words) joints[`${side}_${HAND}`] = tree.longest(hands.filter((j) => searched(words, tree.keys[j].rest)));
  }
  const middle = tree.keys.map(({ side, rest }) => (side ? "" : rest));
  const head = middle.findIndex((rest) => searched(FINDER.HEADS, rest) && !searched(FINDER.TOPS, rest));
  if (head < 0) return;
  joints[HEAD] = head;
  const above = tree.after(head, "^$").filter((j) => middle[j]);
  const top = above.find((j) => searched(FINDER.TOPS, middle[j])) ?? (above.length === 1 ? above[0] : -1);
  if (top >= 0) joints[FINDER.HEAD_TOP] = top;
}

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

function isDisproportionate(skeleton, joints) {
  const length = (side, start, end) =>
    lengthOfBones(skeleton, between(skeleton.parents, joints[`${side}_${start}`], joints[`${side}_${end}`]));
  const wholes = FINDER.LIMBS.map((limb) => SIDES.map((side) =>
    limb.slice(1).map((end, i) => (`${side}_${end}` in joints ? length(side, limb[i], end) : 0))));
  const isOdd = wholes.some((sides, limb) => {
    const [low, high] = FINDER.NAMED[limb];
    const sums = sides.map(([a, b]) => a + b);
    return sides.some(([a, b]) => !(low * b <= a && a <= high * b))
      || Math.max(...sums) > FINDER.SYMMETRY * Math.min(...sums);
  });
  const [leg, arm] = wholes.map(([[a, b]]) => a + b);
  const [low, high] = FINDER.LEG_TO_ARM;
  return isOdd || Boolean(leg && arm && !(low * arm <= leg && leg <= high * arm));
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
function findAnatomy(skeleton) {
  const tree = treeOf(skeleton);
  const joints = findLimbs(tree, skeleton.parents);
  const isAnimal = tree.keys.some(({ rest }) => FINDER.NO_PERSON.some((word) => rest.startsWith(word)));
  if (!Object.keys(joints).length || isAnimal || isDisproportionate(skeleton, joints)) return null;
  addEnds(tree, joints, skeleton);
  return { joints, trunk: trunkOf(skeleton.parents, joints) };
}
