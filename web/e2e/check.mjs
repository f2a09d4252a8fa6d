export const check = [];
