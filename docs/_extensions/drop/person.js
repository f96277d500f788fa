// The shape of a person: head, trunk, limbs, hands and feet, as hulls of spheres. The rules are those of
// skpose/view/_person_shape.py, and names and numbers come from there.

const SHAPE = data.constants.person;
const SHARES = SHAPE.PROPORTIONS;

function heightOf(skeleton, joints) {
  for (const [start, end, share] of [
    [HIP, ANKLE, SHARES.thigh + SHARES.shank],
    [SHOULDER, WRIST, SHARES.upper_arm + SHARES.forearm],
  ]) {
    const ends = SIDES.map((side) => [start, end].map((mark) => joints[`${side}_${mark}`]));
    if (ends.flat().includes(undefined)) continue;
    const lengths = ends.map((pair) => lengthOfBones(skeleton, between(skeleton.parents, ...pair)));
    return (lengths[0] + lengths[1]) / 2 / share;
  }
  return 0;
}

class Person {
  constructor(skeleton, { joints, trunk }, height) {
    Object.assign(this, { skeleton, joints, trunk, height, spheres: [], parts: [], covered: new Set() });
    this.where = positionsAtZero(skeleton);
    [this.hips, this.shoulders] = [HIP, SHOULDER].map((mark) => SIDES.map((side) => this.point(side, mark)));
  }

  get hasTrunk() {
    return [...this.hips, ...this.shoulders].every((point) => point > 0);
  }

  point(side, mark) {
    return (this.joints[`${side}_${mark}`] ?? -1) + 1;
  }

  /** Add a sphere, with lengths as shares of the height; return its index. */
  sphere(at, radius, { weights, along, across, inside } = {}) {
    const sphere = { at, radius: this.height * radius };
    if (weights) sphere.weights = weights;
    if (along) sphere.along = [along[0], along[1], this.height * along[2]];
    if (across) sphere.across = [across[0], across[1], this.height * across[2]];
    if (inside) sphere.inside = true;
    return this.spheres.push(sphere) - 1;
  }

  add(joint, ...hulls) {
    this.parts.push([joint, hulls]);
  }

  cover(joints) {
    for (const joint of joints) this.covered.add(joint);
  }

  addLimbs() {
    const [ofLeg, ofArm] = FINDER.LIMBS;
    for (const side of SIDES) {
      const [leg, arm] = [ofLeg, ofArm].map((limb) => limb.map((mark) => this.point(side, mark)));
      if (leg.every((point) => point)) this.addLeg(side, ...leg);
      if (arm.every((point) => point)) this.addArm(side, ...arm);
    }
  }

  addLeg(side, hip, knee, ankle) {
    const { parents } = this.skeleton;
    const upper = this.sphere(...this.hip(side, SHAPE.R_HIP, { inside: true }));
    const lower = this.sphere([knee], SHAPE.R_KNEE, { inside: true });
    const calf = this.sphere([knee], SHAPE.R_CALF, { along: [[knee], [ankle], SHAPE.CALF * SHARES.shank] });
    const foot = this.sphere([ankle], SHAPE.R_ANKLE, { inside: true });
    this.add(knee - 1, [upper, lower]);
    this.add(ankle - 1, [lower, calf, foot]);
    this.cover(between(parents, hip - 1, ankle - 1));
    const [ballOfFoot, endOfToes] = [BALL, TOE].map((mark) => this.point(side, mark));
    if (!ballOfFoot && !endOfToes) return; // where it points is not known
    const [first, last] = [ballOfFoot || endOfToes, endOfToes || ballOfFoot];
    const shifts = ([along, across]) => ({ along: [[ankle], [first], along], across: [[knee], [ankle], across] });
    const heel = this.sphere([ankle], SHAPE.R_HEEL, shifts(SHAPE.HEEL));
    if (!ballOfFoot) {
      this.add(first - 1, [foot, heel, this.sphere([last], SHAPE.R_TOE)]);
    } else {
      const ball = this.sphere([first], SHAPE.R_BALL);
      const toe = this.sphere([last], SHAPE.R_TOE, endOfToes ? {} : shifts(SHAPE.TIP_OF_TOE));
      this.add(first - 1, [foot, heel, ball], [ball, toe]);
    }
    this.cover(between(parents, ankle - 1, last - 1));
  }

  addArm(side, shoulder, elbow, wrist) {
    const { parents } = this.skeleton;
    const upper = this.sphere([shoulder], SHAPE.R_SHOULDER, { inside: true });
    const lower = this.sphere([elbow], SHAPE.R_ELBOW, { inside: true });
    const forearm = [[elbow], [wrist], SHAPE.FOREARM * SHARES.forearm];
    const bulge = this.sphere([elbow], SHAPE.R_FOREARM, { along: forearm });
    const hand = this.sphere([wrist], SHAPE.R_WRIST, { inside: true });
    this.add(elbow - 1, [upper, lower]);
    this.add(wrist - 1, [lower, bulge, hand]);
    this.cover(between(parents, shoulder - 1, wrist - 1));
    const after = this.after(wrist - 1);
    const known = this.point(side, HAND);
    if (after.filter((j) => !parents.includes(j)).length > SHAPE.FEW_FINGERS) {
      const knuckles = after.filter((j) => parents[j] === wrist - 1 && this.length(j));
      this.add((known || wrist) - 1, [hand, ...knuckles.map((j) => this.sphere([j + 1], SHAPE.R_TIP))]);
      for (const j of after) if (!knuckles.includes(j) && this.length(j)) this.addLink(j, SHAPE.R_FINGER);
      this.cover(after);
      return;
    }
    const toward = known ? [[wrist], [known]] : [[elbow], [wrist]];
    const reach = (j) => lengthOfBones(this.skeleton, between(parents, wrist - 1, j)) / this.height;
    const far = (after.length ? Math.max(...after.map(reach)) : 0) - SHAPE.R_TIP;
    const length = Math.min(Math.max(far, SHAPE.HAND_LENGTH), SHARES.hand);
    const middle = this.sphere([wrist], SHAPE.R_PALM, { along: [...toward, SHAPE.PALM * length] });
    const tip = this.sphere([wrist], SHAPE.R_TIP, { along: [...toward, length] });
    this.add((known || wrist) - 1, [hand, middle, tip]);
    if (known) this.cover(after);
  }

  addLink(joint, radius) {
    const start = this.sphere([this.skeleton.parents[joint] + 1], radius, { inside: true });
    this.add(joint, [start, this.sphere([joint + 1], radius)]);
  }

  /** The points, the radius and the weights of a sphere at a hip that is not wider than a person's. */
  hip(side, radius, more) {
    const here = this.hips[SIDES.indexOf(side)];
    const other = this.hips[1 - SIDES.indexOf(side)];
    const width = Math.hypot(...minus(this.where[here - 1], this.where[other - 1])) / this.height;
    const share = width ? Math.max(0, 0.5 * width + radius - SHAPE.WIDEST) / width : 0;
    return share > 0
      ? [[here, other], radius, { weights: [1 - share, share], ...more }]
      : [[here], radius, more];
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
    let best = [0, SHAPE.WAIST[0]];
    let nearest = Infinity;
    for (const joint of up.some(Boolean) ? this.trunk : []) {
      const share = dot(minus(this.where[joint], low), up) / dot(up, up);
      const apart = Math.abs(share - SHAPE.WAIST[0]);
      if (least < share && share < most && apart < nearest) [best, nearest] = [[joint + 1, share], apart];
    }
    return best;
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
      let above = joint;
      while (above >= 0 && !this.length(above)) above = parents[above];
      const before = (parents[above] ?? -1) + 1;
      return { joint, at, line: [before && !shoulders.includes(before) ? [before] : shoulders, at], skull };
    }
    return null;
  }

  addRest() {
    this.skeleton.parents.forEach((_, j) => {
      if (!this.covered.has(j) && this.length(j)) this.addLink(j, SHAPE.R_MARKER);
    });
  }
}

/** The shape of a person; null for what is none with hips and shoulders. */
function personShape(skeleton) {
  const found = findLandmarks(skeleton);
  const height = found ? heightOf(skeleton, found.joints) : 0;
  const person = height ? new Person(skeleton, found, height) : null;
  if (!person?.hasTrunk) return null;
  person.addLimbs();
  person.addTrunk(person.addHead());
  person.addRest();
  return { spheres: person.spheres, parts: person.parts };
}
