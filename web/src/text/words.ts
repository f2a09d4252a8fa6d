// Every text of the page, Chinese first. One list, so that no text can exist in one language only.
import { labelWords } from "./label_words.ts";
import { screenWords } from "./screen_words.ts";

export const words = { ...screenWords, ...labelWords };
