// Names of category values in scenes: object classes, meta actions, turn signals, lights. [Chinese, English].
import type { Lang } from "./text.svelte.ts";
import type { TextPair } from "./screen_texts.ts";

const names: Record<string, TextPair> = {
  car: ["轿车", "car"],
  truck: ["卡车", "truck"],
  bus: ["客车", "bus"],
  large_vehicle: ["大型车", "large vehicle"],
  motorcycle: ["摩托车", "motorcycle"],
  tricycle: ["三轮车", "tricycle"],
  emergency_vehicle: ["应急车辆", "emergency vehicle"],
  e_bike: ["电动自行车", "e-bike"],
  bicycle: ["自行车", "bicycle"],
  bicyclist: ["骑行者", "cyclist"],
  motorcyclist: ["摩托骑手", "motorcyclist"],
  pedestrian: ["行人", "pedestrian"],
  wheeled_pedestrian: ["推车或轮椅", "person on wheels"],
  animal: ["动物", "animal"],
  cone: ["锥桶", "cone"],
  barrier: ["水马或隔离墩", "barrier"],
  static_object: ["静态障碍物", "static object"],
  unknown: ["未知", "unknown"],

  stop: ["停住", "stop"],
  reverse: ["倒车", "reverse"],
  strong_decelerate: ["急减速", "strong decelerate"],
  gentle_decelerate: ["轻减速", "gentle decelerate"],
  maintain_speed: ["匀速", "maintain speed"],
  gentle_accelerate: ["轻加速", "gentle accelerate"],
  strong_accelerate: ["急加速", "strong accelerate"],
  go_straight: ["直行", "go straight"],
  steer_left: ["向左打方向", "steer left"],
  steer_right: ["向右打方向", "steer right"],
  sharp_steer_left: ["向左急打方向", "sharp steer left"],
  sharp_steer_right: ["向右急打方向", "sharp steer right"],
  reverse_left: ["向左倒车", "reverse left"],
  reverse_right: ["向右倒车", "reverse right"],

  off: ["关", "off"],
  left: ["左", "left"],
  right: ["右", "right"],
  uturn: ["掉头", "U-turn"],
  hazard: ["双闪", "hazard"],
  none: ["无", "none"],
  red: ["红", "red"],
  yellow: ["黄", "yellow"],
  red_yellow: ["红黄", "red and yellow"],
  green: ["绿", "green"],
};

/** The name of a value in a language; unknown values keep their id. */
export function categoryName(value: string | boolean, lang: Lang): string {
  if (typeof value === "boolean") return lang === "zh" ? (value ? "是" : "否") : value ? "yes" : "no";
  return names[value]?.[lang === "zh" ? 0 : 1] ?? value.replaceAll("_", " ");
}
