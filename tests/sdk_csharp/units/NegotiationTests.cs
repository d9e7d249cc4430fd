using System.Collections.Generic;
using System.Linq;
using OpenRoIS;
using OpenRoIS.Media;

public static class NegotiationTests
{
    public static void AnOfferOpensAPeerAndIsAnswered()
    {
        var negotiation = new Negotiation();
        Check.Equal("Open a, Apply a1", Said(negotiation.Offered(Offer("a", 1))));
        Check.Equal("", Said(negotiation.Received(Candidate("a", 1, "remote"))));
        Check.Equal("", Said(negotiation.Gathered("a", new Candidate { CandidateValue = "local" })));
        // What has waited for the description comes behind the answer.
        Check.Equal("SendAnswer a1, SendCandidate a1 local, AddCandidate a1 remote", Said(negotiation.Answered("a", 1, "sdp")));
        Check.Equal("AddCandidate a1 more", Said(negotiation.Received(Candidate("a", 1, "more"))));
        Check.Equal("SendCandidate a1 mine", Said(negotiation.Gathered("a", new Candidate { CandidateValue = "mine" })));
        Check.Equal("", Said(negotiation.Answered("a", 1, "again")));
    }

    public static void OffersOfOnePeerAreAppliedOneAtATime()
    {
        var negotiation = new Negotiation();
        Said(negotiation.Offered(Offer("a", 1)));
        Check.Equal("", Said(negotiation.Offered(Offer("a", 2))));
        Check.Equal("", Said(negotiation.Offered(Offer("a", 3))));
        Check.Equal("", Said(negotiation.Offered(Offer("a", 3))));
        Check.Equal("SendAnswer a1, Apply a3", Said(negotiation.Answered("a", 1, "sdp")));
        Check.Equal("", Said(negotiation.Answered("a", 2, "sdp")));
        Check.Equal("SendAnswer a3", Said(negotiation.Answered("a", 3, "sdp")));
        Check.Equal("", Said(negotiation.Offered(Offer("a", 2))));
        Check.Equal("Apply a4", Said(negotiation.Offered(Offer("a", 4))));
        Check.Equal("", Said(negotiation.Received(Candidate("a", 5, "of what is not there yet"))));
    }

    public static void APeerThatHasEndedIsNotOpenedAgain()
    {
        var negotiation = new Negotiation();
        Said(negotiation.Offered(Offer("a", 1)));
        Check.Equal("Close a", Said(negotiation.Ended("a", "bye")));
        Check.Equal("", Said(negotiation.Ended("a", "bye")));
        Check.Equal("", Said(negotiation.Offered(Offer("a", 2))));
        Check.Equal("", Said(negotiation.Answered("a", 1, "late")));
        Check.Equal("", Said(negotiation.Gathered("a", new Candidate())));
        Check.Equal("", Said(negotiation.Received(Candidate("a", 1, "late"))));
        Said(negotiation.Offered(Offer("b", 1)));
        Said(negotiation.Offered(Offer("c", 1)));
        Check.Equal("Close b, Close c", Said(negotiation.EndedAll("gone")));
        for (int number = 0; number < 100; number++)
        {
            Said(negotiation.Ended("peer " + number, "bye"));
        }
        // So many are remembered, and no more.
        Check.Equal("", Said(negotiation.Offered(Offer("peer 99", 1))));
        Check.Equal("Open peer 0, Apply peer 01", Said(negotiation.Offered(Offer("peer 0", 1))));
    }

    public static void PeersAndWaitingCandidatesAreBounded()
    {
        var negotiation = new Negotiation();
        for (int number = 0; number < Negotiation.MostPeers; number++)
        {
            Check.Equal(2, negotiation.Offered(Offer("p" + number, 1)).Count());
        }
        Check.Equal("", Said(negotiation.Offered(Offer("one too many", 1))));
        for (int number = 0; number < 2 * Negotiation.MostWaiting; number++)
        {
            Said(negotiation.Received(Candidate("p0", 1, "remote")));
            Said(negotiation.Gathered("p0", new Candidate()));
        }
        Check.Equal(1 + 2 * Negotiation.MostWaiting, negotiation.Answered("p0", 1, "sdp").Count());
    }

    private static Offer Offer(string peerId, int generation)
    {
        return new Offer { PeerId = peerId, Generation = generation, Sdp = "v=0" };
    }

    private static Candidate Candidate(string peerId, int generation, string value)
    {
        return new Candidate { PeerId = peerId, Generation = generation, CandidateValue = value };
    }

    private static string Said(IEnumerable<Effect> effects)
    {
        return string.Join(", ", effects.ToList().Select(effect =>
        {
            string said = effect.Kind + " " + effect.PeerId;
            switch (effect.Kind)
            {
                case EffectKind.Apply:
                    return said + effect.Offer.Generation;
                case EffectKind.SendAnswer:
                    return said + effect.Answer.Generation;
                case EffectKind.AddCandidate:
                case EffectKind.SendCandidate:
                    return said + effect.Candidate.Generation + " " + effect.Candidate.CandidateValue;
                default:
                    return said;
            }
        }));
    }
}
