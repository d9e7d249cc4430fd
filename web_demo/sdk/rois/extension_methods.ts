/** The methods of extensions that are not OpenRoIS's own. */

/**
 * Declares methods that a gateway of another maker serves, so that `Client.call` takes them:
 *
 *     declare module "openrois" {
 *       interface ExtensionMethods {
 *         "example.dance": { params: { readonly beats: number }; result: ReturnResult };
 *       }
 *     }
 */
export interface ExtensionMethods {}
