// The shape of a person: head, trunk, limbs, hands and feet, as hulls of spheres. The rules are those of
// skpose/view/_shape.py, and names and numbers come from there.

const SHAPE = data.constants.person;
const SHARES = SHAPE.PROPORTIONS;

class Person {
  constructor(skeleton, { joints, trunk }) {
    Object.assign(this, { skeleton, joints, trunk, spheres: [], parts: [], covered: new Set() });
    this.where = positionsAtZero(skeleton);
    [this.hips, this.shoulders] = [HIP, SHOULDER].map((mark) => SIDES.map((side) => this.point(side, mark)));
    const [left, right] = SIDES.map((side) => [HIP, ANKLE].map((mark) => joints[`${side}_${mark}`]))
      .map((ends) => lengthOfBones(skeleton, between(skeleton.parents, ...ends)));
    this.height = (left + right) / 2 / (SHARES.thigh + SHARES.shank);
  }

  point(side, mark) {
    return (this.joints[`${side}_${mark}`] ?? -1) + 1;
  }

  /** Add a sphere, with lengths as shares of the height; return its index. */
  sphere(at, radius, { along, across, ...others } = {}) {
    const sphere = { at, radius: this.height * radius, ...others };
    if (along) sphere.along = [along[0], along[1], this.height * along[2]];
    if (across) sphere.across = [across[0], across[1], this.height * across[2]];
    return this.spheres.push(sphere) - 1;
  }

  add(joint, ...hulls) {
    this.parts.push([joint, hulls]);
  }

  cover(joints) {
    for (const joint of joints) this.covered.add(joint);
  }

  /** Add the two parts of an arm or a leg below a sphere; return the sphere of the wrist or the ankle. */
  addLimb([first, middle, last], radii, upper, bulge) {
    const lower = this.sphere([middle], radii[0], { inside: true });
    const thickest = this.sphere([middle], radii[1], { along: [[middle], [last], bulge] });
    const end = this.sphere([last], radii[2], { inside: true });
    this.add(middle - 1, [upper, lower]);
    this.add(last - 1, [lower, thickest, end]);
    this.cover(between(this.skeleton.parents, first - 1, last - 1));
    return end;
  }

  addLeg(side) {
    const [hip, knee, ankle, ball, toe] = [HIP, KNEE, ANKLE, BALL, TOE].map((mark) => this.point(side, mark));
    const upper = this.sphere(...this.hip(side, SHAPE.R_HIP, { inside: true }));
    const radii = [SHAPE.R_KNEE, SHAPE.R_CALF, SHAPE.R_ANKLE];
    const foot = this.addLimb([hip, knee, ankle], radii, upper, SHAPE.CALF * SHARES.shank);
    if (!ball && !toe) return; // where it points is not known
    const [first, last] = [ball || toe, toe || ball];
    const shifts = ([along, across]) => ({ along: [[ankle], [first], along], across: [[knee], [ankle], across] });
    const heel = this.sphere([ankle], SHAPE.R_HEEL, shifts(SHAPE.HEEL));
    const middle = ball ? [this.sphere([ball], SHAPE.R_BALL)] : [];
    const front = this.sphere([last], SHAPE.R_TOE, toe ? {} : shifts(SHAPE.TIP_OF_TOE));
    this.add(first - 1, [foot, heel, ...(ball ? middle : [front])], ...middle.map((one) => [one, front]));
    this.cover(between(this.skeleton.parents, ankle - 1, last - 1));
  }

  addArm(side) {
    const { parents } = this.skeleton;
    const [shoulder, elbow, wrist, known] = [SHOULDER, ELBOW, WRIST, HAND].map((mark) => this.point(side, mark));
    const upper = this.sphere([shoulder], SHAPE.R_SHOULDER, { inside: true });
    const radii = [SHAPE.R_ELBOW, SHAPE.R_FOREARM, SHAPE.R_WRIST];
    const hand = this.addLimb([shoulder, elbow, wrist], radii, upper, SHAPE.FOREARM * SHARES.forearm);
    const after = this.after(wrist - 1);
    if (after.filter((j) => !parents.includes(j)).length > SHAPE.FEW_FINGERS) {
      const knuckles = after.filter((j) => parents[j] === wrist - 1 && this.length(j));
      this.add((known || wrist) - 1, [hand, ...knuckles.map((j) => this.sphere([j + 1], SHAPE.R_TIP))]);
      for (const j of after) if (!knuckles.includes(j)) this.addLink(j, SHAPE.R_FINGER);
      this.cover(after);
      return;
    }
    const toward = known ? [[wrist], [known]] : [[elbow], [wrist]];
    const reach = after.map((j) => lengthOfBones(this.skeleton, between(parents, wrist - 1, j)) / this.height);
    const length = Math.min(Math.max(Math.max(0, ...reach) - SHAPE.R_TIP, SHAPE.HAND_LENGTH), SHARES.hand);
    const middle = this.sphere([wrist], SHAPE.R_PALM, { along: [...toward, SHAPE.PALM * length] });
    const tip = this.sphere([wrist], SHAPE.R_TIP, { along: [...toward, length] });
    this.add((known || wrist) - 1, [hand, middle, tip]);
    if (known) this.cover(after);
  }

  addLink(joint, radius) {
    if (!this.length(joint)) return;
    const start = this.sphere([this.skeleton.parents[joint] + 1], radius, { inside: true });
    this.add(joint, [start, this.sphere([joint + 1], radius)]);
  }

  /** The points, the radius and the weights of a sphere at a hip that is not wider than a person's. */
  hip(side, radius, more) {
    const [here, other] = side === SIDES[0] ? this.hips : [...this.hips].reverse();
    const width = Math.hypot(...minus(this.where[here - 1], this.where[other - 1])) / this.height;
    const share = (0.5 * width + radius - SHAPE.WIDEST) / width;
    return share > 0 ? [[here, other], radius, { weights: [1 - share, share], ...more }] : [[here], radius, more];
  }

  length(joint) {
    return lengthOfBones(this.skeleton, [joint]);
  }

  after(joint) {
    const { parents } = this.skeleton;
    return parents.map((_, j) => j).filter((j) => isAfter(parents, j, joint));
  }

  /** Add the trunk, with the hull of the neck if there is one. */
  addTrunk(neck) {
    const [at, up] = this.spine();
    const points = [...this.hips, ...this.shoulders, ...(at ? [at] : [])];
    /** Spheres for both sides at a share of the way up, so far to the side. */
    const level = (radius, [share, ofHips, ofShoulders], spine = 0) => [0.5, -0.5].map((side) => {
      const ends = [[0.5 * (1 - share) * (1 - spine), ofHips], [0.5 * share * (1 - spine), ofShoulders]];
      const weights = ends.flatMap(([weight, width]) => [weight + side * width, weight - side * width]);
      return [points, radius, { weights: [...weights, ...(at ? [spine] : [])] }];
    });
    const add = (spheres) => spheres.map((sphere) => this.sphere(...sphere));
    const line = [this.hips, this.shoulders];
    const pelvis = add(SIDES.map((side) => this.hip(side, SHAPE.R_PELVIS, { along: [...line, SHAPE.PELVIS] })));
    const crotch = this.sphere(this.hips, SHAPE.R_CROTCH, { along: [...line, SHAPE.CROTCH] });
    const band = add(SIDES.map((side) => this.hip(side, SHAPE.R_PELVIS).with(1, SHAPE.R_CROTCH)));
    const waist = add(level(SHAPE.R_WAIST, [up, ...SHAPE.WAIST.slice(1)], at ? SHAPE.SPINE : 0));
    const ribs = add(level(SHAPE.R_RIBS, SHAPE.RIBS));
    const chest = add(level(SHAPE.R_CHEST, SHAPE.CHEST));
    const [collar] = add(level(SHAPE.R_NECK, SHAPE.COLLARS).slice(0, 1));
    const hulls = [[crotch, ...band, ...pelvis, ...waist], [...waist, ...ribs], [...ribs, ...chest, collar]];
    this.add(this.trunk.at(-1) ?? -1, ...hulls, ...(neck.length ? [neck] : []));
    for (const end of [...this.hips, ...this.shoulders]) this.cover(pathUp(this.skeleton.parents, end - 1));
  }

  /** A point of the spine near the waist, if there is one, and how far up from hips to shoulders it is. */
  spine() {
    const middle = (pair) => middleOf(...pair.map((point) => this.where[point - 1]));
    const [low, high] = [middle(this.hips), middle(this.shoulders)];
    const up = minus(high, low);
    const [least, most] = SHAPE.SPINE_BETWEEN;
    const apart = ([, share]) => Math.abs(share - SHAPE.WAIST[0]);
    const near = this.trunk.map((joint) => [joint + 1, dot(minus(this.where[joint], low), up) / dot(up, up)])
      .filter(([, share]) => least < share && share < most);
    return near.sort((a, b) => apart(a) - apart(b))[0] ?? [0, SHAPE.WAIST[0]];
  }

  addHead() {
    const found = this.findHead();
    if (!found) return [];
    const { joint, at, line, skull } = found;
    const along = [...line, skull];
    const below = [...line, skull - SHAPE.CHIN];
    const top = this.sphere(at, SHAPE.R_SKULL, { along });
    const chin = this.sphere(at, SHAPE.R_CHIN, { along: below });
    const base = this.sphere([...this.shoulders, ...this.hips], SHAPE.R_NECK, { weights: SHAPE.NECK, inside: true });
    const throat = this.sphere(at, SHAPE.R_THROAT, { along: below, inside: true });
    this.add(joint, [top, chin]);
    const { parents, names } = this.skeleton;
    this.cover(pathUp(parents, joint));
    const isOfFace = (j) => SHAPE.FACE.some((word) => names[j].toLowerCase().includes(word));
    const isNear = (j) => Math.hypot(...minus(this.where[j], this.where[joint])) < SHAPE.NEAR_HEAD * this.height;
    this.cover(this.after(joint).filter((j) => isNear(j) || isOfFace(j)));
    return [base, throat];
  }

  /** Where the head is, by its joint, its end or its middle; null if that is not known. */
  findHead() {
    const { joints, shoulders, skeleton: { parents } } = this;
    const top = joints[SHAPE.HEAD_TOP];
    for (const [mark, skull] of [[HEAD, SHAPE.SKULL], [SHAPE.HEAD_TOP, -SHAPE.R_SKULL], [SHAPE.HEAD_CENTER, 0]]) {
      const joint = joints[mark];
      if (joint === undefined) continue;
      const at = [joint + 1];
      if (mark === HEAD && top !== undefined && this.length(top)) {
        const crown = Math.min(this.length(top) / this.height, SHARES.head);
        return { joint, at, line: [at, [top + 1]], skull: Math.max(skull, crown - SHAPE.R_SKULL) };
      }
      const above = pathUp(parents, joint).find((j) => this.length(j));
      const before = (parents[above] ?? -1) + 1;
      return { joint, at, line: [before && !shoulders.includes(before) ? [before] : shoulders, at], skull };
    }
    return null;
  }
}

/** The shape of a person with both arms and legs; null for other skeletons. */
function personShape(skeleton) {
  const found = findAnatomy(skeleton);
  const marks = FINDER.LIMBS.flat().flatMap((mark) => SIDES.map((side) => `${side}_${mark}`));
  if (!found || !marks.every((mark) => mark in found.joints)) return null;
  const person = new Person(skeleton, found);
  if (!person.height) return null;
  for (const side of SIDES) {
    person.addLeg(side);
    person.addArm(side);
  }
  person.addTrunk(person.addHead());
  skeleton.parents.forEach((_, j) => person.covered.has(j) || person.addLink(j, SHAPE.R_MARKER));
  return { spheres: person.spheres, parts: person.parts };
}
