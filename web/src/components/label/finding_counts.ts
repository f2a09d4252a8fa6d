// How many findings of which severity, in words: only those that there are. Of a label with changes that nobody has
// checked, no findings are no result.
import type { Finding } from "../../api/types.ts";
import { t } from "../../text/text.svelte.ts";

export function findingCounts(findings: readonly Finding[], unchecked = false): string {
  const errors = findings.filter((f) => f.severity === "error").length;
  const warnings = findings.filter((f) => f.severity === "warning").length;
  const notes = findings.length - errors - warnings;
  const said = [
    errors > 0 ? t("findings.errors", { n: errors }) : "",
    warnings > 0 ? t("findings.warnings", { n: warnings }) : "",
    notes > 0 ? t("findings.notes", { n: notes }) : "",
    unchecked ? t("findings.unchecked") : "",
  ];
  return said.filter(Boolean).join(" · ") || t("findings.none");
}
