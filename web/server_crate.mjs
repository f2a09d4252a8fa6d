// Where the labeling service is: its OpenAPI document is read, and the built page is written, in this crate.
export const server = "../crates/whyroad-server";
