//! What moves in the town: cars that follow their lanes, keep their distance and wait at red, people who walk around
//! junctions and cross when they may, and parked cars. Deterministic: all chance comes from the seed.

use super::city::{BLOCK_M, JUNCTION_M, LANE_M, Lane, Point, SIDE, middle};

/// Steps of a tenth of a second.
pub const STEP_S: f64 = 0.1;
/// Steps before the recording begins.
const WARM_UP: usize = 200;
/// Objects within this distance of the ego are seen, m.
const SENSOR_M: f64 = 100.0;

/// Random numbers in [0, 1).
pub struct Random(u64);

impl Random {
    /// A stream of its own for each seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// The next number.
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// How an object moves.
enum Motion {
    /// Along a lane: which, how far, speed wanted.
    Lane { lane: usize, s: f64, next: usize, wanted: f64 },
    /// Around a junction's corners: which junction, half the side of the square, how far around it, speed.
    Walk { junction: (usize, usize), half: f64, s: f64, pace: f64 },
    /// Not at all.
    Parked,
}

/// One object.
pub struct Agent {
    motion: Motion,
    /// Center, m.
    pub at: Point,
    /// rad.
    pub heading: f64,
    speed: f64,
    /// Length, width, height, m.
    pub size: [f64; 3],
    /// Category of Argoverse 2.
    pub category: &'static str,
}

/// One object at one time as the ego's sensors see it.
#[derive(Clone, Copy)]
pub struct Seen {
    /// Index of the agent.
    pub agent: usize,
    /// Index of the frame.
    pub frame: usize,
    /// Center, m.
    pub at: Point,
    /// rad.
    pub heading: f64,
}

/// A drive: the ego's poses, and what it sees.
pub struct Recording {
    /// The town's objects; the ego is the first.
    pub agents: Vec<Agent>,
    /// Center and heading of the ego by frame.
    pub ego: Vec<(Point, f64)>,
    /// By agent, then frame.
    pub seen: Vec<Seen>,
}

/// Whether lanes of avenues (else streets) have green at a junction.
fn is_green(time: f64, junction: (usize, usize), avenue: bool) -> bool {
    let phase = (time + 7.0 * (junction.0 + 2 * junction.1) as f64) % 44.0;
    if avenue { phase < 20.0 } else { (22.0..42.0).contains(&phase) }
}

fn populate(lanes: &[Lane], objects: usize, random: &mut Random) -> Vec<Agent> {
    let town = (SIDE as f64 - 1.0) * BLOCK_M + 2.0 * JUNCTION_M;
    // More than are needed: some of the surplus is left out of the log.
    let all = (2.2 * objects as f64 * town * town / (std::f64::consts::PI * SENSOR_M * SENSOR_M)) as usize;
    let roads: Vec<usize> = (0..lanes.len()).filter(|i| !lanes[*i].in_junction).collect();
    let mut agents: Vec<Agent> = Vec::new();
    let mut taken: Vec<(usize, usize)> = Vec::new();
    while agents.len() < all {
        let kind = if agents.is_empty() { 0.0 } else { random.next() };
        let parked = kind >= 0.35;
        let lane = roads[(random.next() * roads.len() as f64) as usize];
        let slot = (if parked { lane + lanes.len() } else { lane }, (random.next() * 10.0) as usize);
        let clash = taken.contains(&slot) || (parked && (!lanes[lane].rightmost || lanes[lane].avenue));
        if kind < 0.7 && clash {
            // A town has no more room than it has: then more people walk.
            if random.next() < 0.9 {
                continue;
            }
        }
        if kind < 0.7 && !clash {
            taken.push(slot);
            let s = slot.1 as f64 * 8.0 + 4.0;
            let (at, heading) = lanes[lane].at(s);
            let large = random.next() < 0.08;
            let size = if large { [9.0, 2.5, 3.2] } else { [4.3 + 0.6 * random.next(), 1.85, 1.6] };
            let category = if large { "BOX_TRUCK" } else { "REGULAR_VEHICLE" };
            let aside = if parked { LANE_M / 2.0 + 1.1 } else { 0.0 };
            let at = (at.0 + aside * heading.sin(), at.1 - aside * heading.cos());
            let wanted = 9.0 + 5.0 * random.next();
            let motion =
                if parked { Motion::Parked } else { Motion::Lane { lane, s, next: usize::MAX, wanted } };
            agents.push(Agent { motion, at, heading, speed: 0.0, size, category });
        } else {
            let junction = ((random.next() * SIDE as f64) as usize, (random.next() * SIDE as f64) as usize);
            let half = JUNCTION_M - 1.2 - 2.6 * random.next();
            let motion =
                Motion::Walk { junction, half, s: random.next() * 8.0 * half, pace: 1.0 + random.next() };
            let size = [0.6, 0.6, 1.75];
            let (at, heading) = ((0.0, 0.0), 0.0);
            agents.push(Agent { motion, at, heading, speed: 0.0, size, category: "PEDESTRIAN" });
        }
    }
    agents
}

/// Point and direction at an arc length around a square.
fn around(junction: (usize, usize), half: f64, s: f64) -> (Point, f64) {
    let (m, side) = (middle(junction), 2.0 * half);
    let (k, t) = (((s / side) as usize) % 4, s % side - half);
    let (x, y) = [(t, -half), (half, t), (-t, half), (-half, -t)][k];
    ((m.0 + x, m.1 + y), [0.0, 0.5, 1.0, -0.5][k] * std::f64::consts::PI)
}

/// A person waits at the curb until the road that they cross has red.
fn may_walk(time: f64, junction: (usize, usize), half: f64, s: f64) -> bool {
    let (k, t) = (((s / (2.0 * half)) as usize) % 4, s % (2.0 * half) - half);
    // Sides 0 and 2 run along the avenue and cross the street.
    let crosses_avenue = k % 2 == 1;
    let curb = -(if crosses_avenue { 2.0 } else { 1.0 }) * LANE_M - 0.6;
    !(curb - 1.0..curb).contains(&t)
        || (!is_green(time, junction, crosses_avenue) && !is_green(time + 8.0, junction, crosses_avenue))
}

/// Free distance ahead of a car to whatever is in front of it, m, and the speed of that.
fn ahead(agents: &[Agent], k: usize) -> (f64, f64) {
    let me = &agents[k];
    let (c, s) = (me.heading.cos(), me.heading.sin());
    let mut nearest = (f64::INFINITY, 0.0);
    for (i, other) in agents.iter().enumerate() {
        let (dx, dy) = (other.at.0 - me.at.0, other.at.1 - me.at.1);
        if i == k || dx.abs() > 45.0 || dy.abs() > 45.0 {
            continue;
        }
        let (x, y) = (dx * c + dy * s, dy * c - dx * s);
        let gap = x - (me.size[0] + other.size[0]) / 2.0;
        if x > 0.0 && y.abs() < (me.size[1] + other.size[1]) / 2.0 + 0.2 && gap < nearest.0 {
            let along = other.speed * (other.heading - me.heading).cos();
            nearest = (gap.max(0.1), along.max(0.0));
        }
    }
    nearest
}

fn step(lanes: &[Lane], agents: &mut [Agent], time: f64, random: &mut Random) {
    let free: Vec<(f64, f64)> = (0..agents.len())
        .map(|k| if matches!(agents[k].motion, Motion::Lane { .. }) { ahead(agents, k) } else { (0.0, 0.0) })
        .collect();
    for (agent, (mut gap, mut lead)) in agents.iter_mut().zip(free) {
        match &mut agent.motion {
            Motion::Parked => {}
            Motion::Walk { junction, half, s, pace } => {
                agent.speed = if may_walk(time, *junction, *half, *s) { *pace } else { 0.0 };
                *s = (*s + agent.speed * STEP_S) % (8.0 * *half);
                (agent.at, agent.heading) = around(*junction, *half, *s);
            }
            Motion::Lane { lane, s, next, wanted } => {
                let here = &lanes[*lane];
                if *next == usize::MAX {
                    *next = here.next[(random.next() * here.next.len() as f64) as usize];
                }
                let line = here.length() - 2.0 - agent.size[0] / 2.0 - *s;
                let red = !here.in_junction && !is_green(time, here.junction, here.avenue);
                if red && line > -1.0 && line < gap && line + 4.0 > agent.speed * agent.speed / 8.0 {
                    (gap, lead) = (line.max(0.1), 0.0);
                }
                let turns = (here.at(0.0).1 - here.at(here.length()).1).abs() > 0.5;
                let wanted = if here.in_junction && turns { 5.0 } else { *wanted };
                // The intelligent driver model (Treiber, Hennecke, Helbing 2000).
                let v = agent.speed;
                let apart = 2.0 + (1.2 * v + v * (v - lead) / (2.0 * (1.5_f64 * 2.5).sqrt())).max(0.0);
                let accel = 1.5 * (1.0 - (v / wanted).powi(4) - (apart / gap).powi(2));
                agent.speed = (v + accel.clamp(-7.0, 1.5) * STEP_S).max(0.0);
                *s += agent.speed * STEP_S;
                if *s >= here.length() {
                    *s -= here.length();
                    *lane = *next;
                    *next = usize::MAX;
                }
                (agent.at, agent.heading) = lanes[*lane].at(*s);
            }
        }
    }
}

/// A drive of `frames` with on average `objects` around the ego in each frame.
pub fn record(lanes: &[Lane], objects: usize, frames: usize, seed: u64) -> Recording {
    let mut random = Random::new(seed);
    let mut agents = populate(lanes, objects, &mut random);
    let mut ego = Vec::with_capacity(frames);
    let mut by_agent: Vec<Vec<Seen>> = agents.iter().map(|_| Vec::new()).collect();
    let start = 44.0 * random.next();
    for i in 0..WARM_UP + frames {
        step(lanes, &mut agents, start + i as f64 * STEP_S, &mut random);
        let Some(frame) = i.checked_sub(WARM_UP) else { continue };
        let own = agents[0].at;
        ego.push((own, agents[0].heading));
        for (k, a) in agents.iter().enumerate().skip(1) {
            if (a.at.0 - own.0).hypot(a.at.1 - own.1) <= SENSOR_M {
                by_agent[k].push(Seen { agent: k, frame, at: a.at, heading: a.heading });
            }
        }
    }
    // As many as were asked for: objects are left out one by one, in no order that means anything.
    let mut order: Vec<usize> = (0..agents.len()).collect();
    for i in (1..order.len()).rev() {
        order.swap(i, (random.next() * (i + 1) as f64) as usize);
    }
    let (mut rows, mut seen) = (0, Vec::new());
    for k in order {
        if rows < objects * frames {
            rows += by_agent[k].len();
            seen.append(&mut by_agent[k]);
        }
    }
    seen.sort_by_key(|s| (s.agent, s.frame));
    Recording { agents, ego, seen }
}
