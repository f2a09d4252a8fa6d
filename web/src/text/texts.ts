// Every text of the page, Chinese first. One list, so that no text exists in one language only.
import { labelTexts } from "./label_texts.ts";
import { screenTexts } from "./screen_texts.ts";

export const texts = { ...screenTexts, ...labelTexts };
