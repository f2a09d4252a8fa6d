export const troubles = [];
