// Entry of the page: mounts the app.
import "./app.css";
import { mount } from "svelte";
import App from "./App.svelte";
import { startRouter } from "./route.svelte.ts";

startRouter();

const target = document.getElementById("app");
if (target) mount(App, { target });
